// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::bench {

/// A parameter that has the same meaning in plant and model.
struct Estimate {
  std::string parameter;
  double truth = 0.0;
  double value = 0.0;
  double standard_error = 0.0;
  double deviation() const { return (value - truth) / standard_error; }
};

/// The estimates of `terms`, with standard errors, for hidden effects that have the formula of the catalogue
/// in the plant. `truth`: the parameters that the plant reports.
std::vector<Estimate> estimates_of(const workbench::Terms& terms, const nlohmann::json& truth);

/// How many estimates lie within one and two standard errors of the truth, of all and of each parameter.
std::string calibration(const std::vector<Estimate>& estimates);

}  // namespace slipstack::bench
