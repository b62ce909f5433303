// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/long_logs/log_search.h"
#include "workbench/model/model.h"
#include "workbench/report/results/comparison_result.h"

namespace slipstack::workbench {

/// Force of a model beside the measured one, at the rows; nothing is fitted. Of several logs each has the
/// load that it declares.
ForceRows force_rows(const Measurement& measurement, const Terms& terms);

/// The work of `slipstack compare`: the error of the model as it is. The result lacks `command_line`, `log`
/// and `model_path`.
ComparisonResult compare_model(LogSearch& logs, Model model, Progress& progress);

}  // namespace slipstack::workbench
