// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/bench/blind/cases.h"

namespace slipstack::bench {

/// The benchmark's tables: what was named, false alarms, error over floor, confusion, calibration, and the
/// same by the ratio of the baseline's error to the noise floor.
std::string summary(const std::vector<Outcome>& outcomes);

/// Figures that are below the threshold of a test run, or above what is possible: one sentence each; none
/// where all are within.
std::vector<std::string> shortfalls(const std::vector<Outcome>& outcomes);

/// One line for one log, to follow the run.
std::string line_of(const Outcome& outcome);

}  // namespace slipstack::bench
