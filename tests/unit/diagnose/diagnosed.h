// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/uncertainty/row_weights.h"

namespace slipstack::workbench::test {

/// The diagnosis of a measurement with mass and hysteresis as baseline. The measurement must outlive the
/// models of the result.
inline Diagnosis diagnosed(Measurement& measurement, std::vector<std::string> candidates = {}) {
  weigh_rows(measurement);
  DiagnoseOptions options;
  options.baseline = {"inertia", "presliding_hysteresis"};
  options.candidates = std::move(candidates);
  return diagnose(measurement, options);
}

/// The same for tests that use only names, gains and errors of the result.
inline Diagnosis diagnosed(const Log& log, std::vector<std::string> candidates = {}) {
  Measurement measurement(log);
  return diagnosed(measurement, std::move(candidates));
}

}  // namespace slipstack::workbench::test
