// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

// What the time stamps of uniform and of irregular samples have in common.
namespace slipstack::workbench {

inline constexpr double kJitterTolerance =
    0.01;  // of a step, in addition to the rounding of the stamps; chosen

// A line through time stamps: stamp i ≈ offset + i·step.
struct StampLine {
  double offset_s = 0.0;
  double step_s = 0.0;
  double at(std::size_t i) const { return offset_s + static_cast<double>(i) * step_s; }
};

// The median of the steps between stamps, of which there are at least two.
double median_step(const std::vector<double>& time_s);

// A whole number of hertz or a period of whole nanoseconds where `count` stamps, of which the worst is
// `worst_s` off a line of slope `step_s`, are compatible with it; else the rate itself.
double rounded_rate_Hz(double step_s, double worst_s, std::size_t count);

}  // namespace slipstack::workbench
