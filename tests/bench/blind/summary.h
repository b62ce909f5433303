// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/bench/blind/cases.h"

namespace slipstack::bench {

/// The benchmark's tables: what was named, false alarms, error over floor, confusion, calibration, and the
/// same by how far the hidden effect stands above the floor.
std::string summary(const std::vector<Outcome>& outcomes);

/// One line for one log, for those who follow the run.
std::string line_of(const Outcome& outcome);

}  // namespace slipstack::bench
