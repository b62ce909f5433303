// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
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

// Samples that were taken evenly though their stamps jitter, as where a clock triggers the converter and a
// computer stamps what it is handed: each stamp lies nearest to its own place of an even grid, of which
// places may be empty (lost samples), and the motion says so. A position read at a wrong time is off by speed
// times jitter, which no mass does: where the two ways to read the log differ most, each position is told
// from its four neighbours much better by place than by stamp. `jitter_s`: the farthest that a stamp is off
// its place.
struct EvenSamples {
  Sampling sampling;
  std::vector<std::size_t> places;  // ascending, the first is 0
  double jitter_s = 0.0;
};
// Empty where the stamps are exact, too far off any grid, or not belied by the motion. O(n).
std::optional<EvenSamples> taken_evenly(const std::vector<double>& time_s,
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

// The same by the cubic through two samples on either side, for the position of a mass: half a step between
// two samples, a straight line is off by an eighth of the acceleration times the step squared, and through
// the mass that is a force.
std::vector<double> resampled_smoothly(const std::vector<double>& time_s, const std::vector<double>& values,
                                       const ResamplingGrid& grid);

}  // namespace slipstack::workbench
