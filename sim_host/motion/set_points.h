// SPDX-License-Identifier: Apache-2.0
// A motion read from a file, sample by sample.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim_host/motion/segment.h"

namespace slipstack::sim {

/// Through `position_m`, `rate_Hz` of them a second: quintics between the samples, whose velocity and
/// acceleration are the central differences there, so that both are continuous; the axis stands at both ends.
/// Throws std::invalid_argument for fewer than three samples or a rate that is not positive.
std::unique_ptr<Segment> make_sampled(std::vector<double> position_m, double rate_Hz);

/// A commanded motion as a file has it. Velocity and acceleration are empty where the file has none.
struct SetPointFile {
  double rate_Hz = 0.0;
  std::vector<double> position_m;
  std::vector<double> velocity_mps;
  std::vector<double> acceleration_mps2;
};

/// The names of the columns of a file of set points.
struct SetPointColumns {
  std::string position = "position_m";
  std::string velocity = "velocity_mps";
  std::string acceleration = "acceleration_mps2";
};

/// Reads a CSV file: `#` lines, a header row with time_s and the position, and perhaps velocity and
/// acceleration, among its names, then rows on a uniform grid of time. The only reader of set points:
/// `slipstack simulate` uses it too. Throws std::runtime_error, one line with file and line.
SetPointFile read_set_points(const std::string& path, const SetPointColumns& columns = {});

/// A commanded motion that is in memory: `points` without a rate, at the times `time_s`. The checks and the
/// rate are those of a file called `name`. Throws std::runtime_error, one line.
SetPointFile with_times(const std::string& name, const std::vector<double>& time_s, SetPointFile points);

}  // namespace slipstack::sim
