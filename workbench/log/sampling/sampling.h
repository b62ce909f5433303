// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace slipstack::workbench {

// Bounds of the time from one sample to the next, in steps: above, a sample is missing; below, a stamp is
// wrong.
inline constexpr double kShortestStep = 0.5;
inline constexpr double kLongestStep = 1.5;

struct Sampling {
  double rate_Hz = 0.0;
  double start_s = 0.0;
};

// Gives the place of a row for messages: "run.csv:17".
using WhereRow = std::function<std::string(std::size_t)>;

// Throws InputError unless the time stamps (seconds, at least two) increase strictly.
void require_growing_time(const std::vector<double>& time_s, const WhereRow& where);

// Estimates the rate of increasing time stamps that may be rounded (to a power of ten, or to
// `storage_error_s`) by the slope of the least-squares line through them; it is replaced by a whole number of
// hertz or a period of whole nanoseconds where the stamps are compatible with it. The start is the first
// stamp. Throws InputError where a sample is missing, or where a stamp deviates from the line by more than 1
// % of a step plus its rounding. O(n).
Sampling uniform_sampling(const std::vector<double>& time_s, double storage_error_s, const WhereRow& where);

// Samples that were taken uniformly although their stamps jitter, as where a clock triggers the converter and
// a computer stamps the values when they arrive. Each stamp is nearest to its own point of a uniform grid,
// points may be empty (lost samples), and the motion is smoother over the grid than over the stamps: a wrong
// time displaces a position by speed times jitter, which no mass does. The test predicts positions from their
// four neighbours where the two assumptions differ most. `jitter_s`: the largest deviation of a stamp from
// its point.
struct EvenSamples {
  Sampling sampling;
  std::vector<std::size_t> places;  // index on the grid of each sample, ascending from 0
  double jitter_s = 0.0;
};
// Empty where the stamps are exact, too far off any grid, or not contradicted by the motion. O(n).
std::optional<EvenSamples> evenly_sampled(const std::vector<double>& time_s,
                                          const std::vector<double>& position);

// The uniform grid on which irregular samples are interpolated: from the first stamp on, with the median
// step. Throws InputError when a step is longer than ten median steps: there is nothing to interpolate. O(n).
struct ResamplingGrid {
  Sampling sampling;
  std::size_t count = 0;
};
ResamplingGrid resampling_grid(const std::vector<double>& time_s, const WhereRow& where);

// `values` at `time_s`, interpolated linearly at the points of the grid. O(n).
std::vector<double> resampled(const std::vector<double>& time_s, const std::vector<double>& values,
                              const ResamplingGrid& grid);

// The same by the cubic through two samples on either side, for the position of a mass: half-way between two
// samples a straight line has an error of an eighth of the acceleration times the step squared, and by way of
// the mass this error would appear as a force.
std::vector<double> resampled_smoothly(const std::vector<double>& time_s, const std::vector<double>& values,
                                       const ResamplingGrid& grid);

}  // namespace slipstack::workbench
