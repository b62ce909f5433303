// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/model/model.h"
#include "workbench/report/results/experiment_result.h"
#include "workbench/simulate/open_loop.h"
#include "workbench/simulate/set_points.h"

// The results of `simulate`. The model and the motion are named as on the command line.
namespace slipstack::workbench {

/// From the force of a log to the position; `start_s` is the time of the first simulated sample in the log.
ExperimentResult open_loop_result(const std::string& model_path, const Model& model, const std::string& log,
                                  const OpenLoop& found, double start_s, double rate_Hz);

/// From set points to the force that they ask for.
ExperimentResult demand_result(const std::string& model_path, const Model& model,
                               const std::string& set_points, const SetPoints& points,
                               const std::vector<double>& force_N);

}  // namespace slipstack::workbench
