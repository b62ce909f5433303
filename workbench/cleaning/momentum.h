// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/base/interval.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {

/// Of pulses of the force, each of a few samples, those that did not move the axis: where a set-point has a
/// kink, a controller with feed-forward pushes for a sample or two, and the velocity changes by impulse over
/// mass. A disturbed sensor moves nothing. Where most of the pulses move nothing, a few that seem to do so by
/// chance are faults too. The mass is the declared one, or that of the pulses, or a rough one of the log.
/// O(pulses), or O(n) where no mass is declared.
std::vector<Interval> without_true_pulses(const Log& log, std::vector<Interval> pulses);

}  // namespace slipstack::workbench
