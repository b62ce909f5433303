// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/uncertainty/noise_floor.h"

namespace slipstack::workbench::test {

/// A measurement against mass and hysteresis; it must outlive what is asked of the models that were fitted.
inline Diagnosis diagnosed(Measurement& measurement, std::vector<std::string> candidates = {}) {
  weigh_rows(measurement);
  DiagnoseOptions options;
  options.baseline = {"inertia", "presliding_hysteresis"};
  options.candidates = std::move(candidates);
  return diagnose(measurement, options);
}

/// The same where only names, gains and errors are asked for.
inline Diagnosis diagnosed(const Log& log, std::vector<std::string> candidates = {}) {
  Measurement measurement(log);
  return diagnosed(measurement, std::move(candidates));
}

}  // namespace slipstack::workbench::test
