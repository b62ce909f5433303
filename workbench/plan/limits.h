// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "workbench/long_logs/unit_sums.h"
#include "workbench/plan/segment_choice.h"

namespace slipstack::workbench {

/// The values of --limits, by key, each checked by itself: for a stroke two numbers, from one end to the
/// other; else one positive number.
using GivenLimits = std::map<std::string, std::vector<double>>;

/// Reads "stroke=0.02:0.38,velocity=0.5,...". Throws UsageError.
GivenLimits parse_limits(const std::string& text);

/// Limits of an axis without logs. Throws UsageError where one is missing.
AxisLimits limits_of_axis(const GivenLimits& given);
/// Limits of an axis with logs: what it has surely done in them (MotionExtremes), each unless given. The
/// motor constant converts a limit of the current into one of the force. Throws UsageError for a limit that
/// is not given and that the logs do not show.
AxisLimits limits_of_axis(const GivenLimits& given, const MotionExtremes& reached,
                          std::optional<double> motor_constant_N_per_A);

}  // namespace slipstack::workbench
