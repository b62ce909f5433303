// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace slipstack::workbench {

// From one sample to the next, in steps: more and one is missing, less and a stamp is wrong.
inline constexpr double kShortestStep = 0.5;
inline constexpr double kLongestStep = 1.5;

struct Sampling {
  double rate_Hz = 0.0;
  double start_s = 0.0;
};

// "run.csv:17" for a row.
using WhereRow = std::function<std::string(std::size_t)>;

// Throws InputError when the time stamps (seconds, at least two) do not grow from each to the next.
void require_growing_time(const std::vector<double>& time_s, const WhereRow& where);

// Derives the rate of growing time stamps that may be rounded (to a power of ten, or to `storage_error_s`),
// as the slope of the least-squares line through them; a whole number of hertz, or a period of whole
// nanoseconds, when the stamps cannot tell it from that. The start is the first stamp. Throws InputError when
// a step is missing, or when a stamp lies off the line by more than 1 % of a step plus its rounding. O(n).
Sampling uniform_sampling(const std::vector<double>& time_s, double storage_error_s, const WhereRow& where);

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

}  // namespace slipstack::workbench
