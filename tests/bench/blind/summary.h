// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/bench/blind/cases.h"

namespace slipstack::bench {

/// The benchmark's tables: what was named, false alarms, error over floor, confusion, calibration, and the
/// same by how far the hidden effect stands above the floor.
std::string summary(const std::vector<Outcome>& outcomes);

/// Where the outcomes fall short of what a small share of the benchmark must reach in every test run, or
/// exceed what is possible: one sentence each, none when all is well.
std::vector<std::string> shortfalls(const std::vector<Outcome>& outcomes);

/// One line for one log, for those who follow the run.
std::string line_of(const Outcome& outcome);

}  // namespace slipstack::bench
