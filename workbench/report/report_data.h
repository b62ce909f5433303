// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

/// A model's force beside the measured one, at the rows.
struct ForceRows {
  Eigen::VectorXd measured_N;
  Eigen::VectorXd model_N;
  Eigen::VectorXd residual_N() const { return measured_N - model_N; }
};

/// Adds what the report draws of a measurement and a model: series, loops, profiles, spectrum, header and how
/// it was measured. `after` (may be null) is a second model, drawn beside the first.
void add_pictures(nlohmann::json& data, const Measurement& measurement, const ForceRows& before,
                  const ForceRows* after);

/// Adds to the profiles that add_pictures() drew what an effect is expected to leave, at the rows.
void add_expected(nlohmann::json& data, const Measurement& measurement, const std::string& name,
                  const Eigen::VectorXd& expected_N);

/// [{effect, title, formula, parameters: [{name, value, standard_error, unit, note}]}]
nlohmann::json parameters_json(const Terms& terms);

/// Candidates and steps as `diagnose --json` promises them (design.md, "Contracts").
nlohmann::json candidates_json(const Diagnosis& diagnosis);
nlohmann::json steps_json(const Diagnosis& diagnosis);

/// A finite number, or null.
nlohmann::json number_json(double value);

}  // namespace slipstack::workbench
