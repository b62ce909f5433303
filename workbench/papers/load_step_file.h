// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim_host/experiments/calibration.h"

namespace slipstack::workbench {

/// Reads a calibration in load steps: CSV, comments with '#', a header row with time_s, load_N (or load_kN)
/// and signal_mV_per_V in any order, then one row for each settled reading. Throws InputError with file and
/// line.
std::vector<sim::LoadStep> read_load_steps(const std::string& path);

/// The steps in the format of read_load_steps().
std::string load_steps_text(const std::string& comment, const std::vector<sim::LoadStep>& steps);

}  // namespace slipstack::workbench
