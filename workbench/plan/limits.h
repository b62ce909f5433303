// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "workbench/long_logs/unit_sums.h"
#include "workbench/plan/plan.h"

namespace slipstack::workbench {

/// What --limits gives, by key, each good by itself: two numbers of a stroke from one end to the other, else
/// one, positive.
using GivenLimits = std::map<std::string, std::vector<double>>;

/// Reads "stroke=0.02:0.38,velocity=0.5,...". Throws UsageError.
GivenLimits parse_limits(const std::string& text);

/// Limits of an axis of which nothing is known. Throws UsageError where one is missing.
AxisLimits limits_of_axis(const GivenLimits& given);
/// Of an axis with logs: what it did in them, it can do again. The constant turns a current into a force.
AxisLimits limits_of_axis(const GivenLimits& given, const MotionExtremes& reached,
                          std::optional<double> motor_constant_N_per_A);

}  // namespace slipstack::workbench
