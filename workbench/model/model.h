// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "firmware/effects/model.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// A friction model as it is stored in a file: what was identified, and what the controller runs of it.
struct Model {
  struct Source {
    std::string log;
    std::int64_t samples = 0;
    double holdout_rmse_N = 0.0;
    double noise_floor_N = 0.0;
    double relative_error = 0.0;
  };
  /// One entry of the history of the model: a fit, or one added effect.
  struct Change {
    std::string date;   ///< UTC, ISO 8601
    std::string added;  ///< effects, separated by commas
    std::string log;
    double before_N = 0.0;  ///< held-out error without them; 0 where there was no earlier model
    double after_N = 0.0;
    double noise_floor_N = 0.0;
  };
  /// A user-defined effect on the controller: represented by a table, or left out.
  struct UserEffectOnTarget {
    std::string id;
    std::string why_not;  ///< empty: `user_table` among target_terms represents it
    std::string over;     ///< "position" or "velocity"
    double from = 0.0;    ///< m or m/s
    double to = 0.0;
    double reversal_velocity_mps = 0.0;
    double largest_error_N = 0.0;
    double peak_N = 0.0;
  };
  Source source;
  std::vector<Change> history;  ///< the oldest first; empty in files of versions that did not write it
  Terms terms;                  ///< as identified
  Terms target_terms;           ///< the same with the hysteresis reduced to the controller's elements
  std::vector<UserEffectOnTarget> target_user_effects;
  double target_holdout_rmse_N = 0.0;  ///< its excess over source.holdout_rmse_N is the cost of the reduction
};

/// The parameter block of the controller.
using TargetParameters = FrictionModel<float>::Parameters;
TargetParameters target_parameters(const Terms& target_terms);

/// The hash that the controller reports for this model.
std::uint32_t target_hash(const Model& model);

/// The model as TOML text.
std::string to_toml(const Model& model);

/// Reads a model file. Throws InputError, one line with file and line number, for anything that is not a
/// model: wrong syntax, an unknown effect or parameter, a missing value or a wrong number of values, a value
/// out of bounds, a hash that does not belong to the parameters.
Model read_model(const std::filesystem::path& path);

/// The same from the `content` of the file, where it is given; `name` then stands for the file in messages.
Model read_model(const std::string& name, const std::optional<std::string>& content);

/// The same for what the controller runs. Throws InputError for a model of a rotary axis: the units of its
/// object dictionary are those of a linear one.
Model read_controller_model(const std::filesystem::path& path);

}  // namespace slipstack::workbench
