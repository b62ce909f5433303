// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/bursts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "workbench/base/interval.h"
#include "workbench/base/quantity.h"
#include "workbench/cleaning/outliers.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// The absolute deviation of each sample of the force from the cubic through its neighbours, part by part.
std::vector<double> jumps_of_force(const Measurement& measurement) {
  const std::vector<double>& force_N = measurement.log().force_N;
  std::vector<double> jumps_N;
  jumps_N.reserve(force_N.size());
  for (const LogPart& part : measurement.parts()) {
    const auto first = force_N.begin() + static_cast<std::ptrdiff_t>(part.first_sample);
    const std::vector<double> own =
        departures_from_cubic({first, first + static_cast<std::ptrdiff_t>(part.sample_count)});
    for (const double jump_N : own) jumps_N.push_back(std::abs(jump_N));
  }
  return jumps_N;
}

/// A sample belongs to the interval if its deviation is at least this share of the largest, and it is at most
/// so many samples away from another that belongs to it. Chosen.
constexpr double kStrongBurst = 0.2;
constexpr std::size_t kNear_samples = 100;

/// The interval of large deviations around the largest.
Interval noisy_interval(const std::vector<double>& jumps_N, std::size_t strongest) {
  const double strong_N = kStrongBurst * jumps_N[strongest];
  Interval burst{strongest, strongest + 1};
  for (std::size_t i = strongest; i-- > 0 && burst.first - i <= kNear_samples;) {
    if (jumps_N[i] >= strong_N) burst.first = i;
  }
  for (std::size_t i = strongest; i < jumps_N.size() && i < burst.end + kNear_samples; ++i) {
    if (jumps_N[i] >= strong_N) burst.end = i + 1;
  }
  return burst;
}

/// The largest magnitude within an interval, and of the samples that are not near it.
struct Extremes {
  double within = 0.0;
  double without = 0.0;
};
Extremes extremes(const std::vector<double>& values, const Interval& interval) {
  Extremes most;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i >= interval.first && i < interval.end) {
      most.within = std::max(most.within, std::abs(values[i]));
    } else if (i + kNear_samples < interval.first || i >= interval.end + kNear_samples) {
      most.without = std::max(most.without, std::abs(values[i]));
    }
  }
  return most;
}

/// A burst takes at most this share of the logs, ...
constexpr double kShortBurst = 0.05;
/// ... has at least so many large deviations (a corner of the force or an outlier makes five), ...
constexpr std::ptrdiff_t kFewestLarge = 12;
/// ... each of them larger by this factor than any other in the logs, ...
constexpr double kAboveAllElse = 2.0;
/// ... and the acceleration there is at most this multiple of that anywhere else. All four chosen on the
/// blind bench.
constexpr double kFaster = 1.5;

}  // namespace

std::optional<Structure> burst_in_force(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  const std::vector<double> jumps_N = jumps_of_force(measurement);
  if (jumps_N.empty()) return {};
  const auto strongest = std::max_element(jumps_N.begin(), jumps_N.end());
  const Interval burst = noisy_interval(jumps_N, static_cast<std::size_t>(strongest - jumps_N.begin()));
  if (static_cast<double>(burst.size()) > kShortBurst * static_cast<double>(jumps_N.size())) return {};
  const double strong_N = kAboveAllElse * extremes(jumps_N, burst).without;
  const auto large = std::count_if(jumps_N.begin() + static_cast<std::ptrdiff_t>(burst.first),
                                   jumps_N.begin() + static_cast<std::ptrdiff_t>(burst.end),
                                   [&](double jump_N) { return jump_N > strong_N; });
  // The only fast move of a log changes the force quickly too.
  const Extremes acceleration = extremes(measurement.acceleration_mps2(), burst);
  if (large < kFewestLarge || acceleration.within > kFaster * acceleration.without) return {};
  const double first_s = measurement.time_s(burst.first);
  const double end_s = measurement.time_s(burst.end - 1);
  const double sample_s = measurement.tick_s();
  const Eigen::VectorXd times = row_times(measurement);
  const Eigen::VectorXd within_N =
      ((times.array() >= first_s) && (times.array() <= end_s)).select(residual_N.array(), 0.0);
  const double share = within_N.squaredNorm() / std::max(residual_N.squaredNorm(), 1e-300);
  return Structure{Coordinate::time, reduction_beyond(share, 0.0), first_s,
                   fmt::format("the force jumps about for {} at {}, by {}, as nowhere else in the log: look "
                               "for a loose plug, a disturbed sensor or a knock",
                               quantity_with_interval(end_s - first_s, sample_s, "s"),
                               when_of(measurement, first_s, sample_s),
                               quantity_with_interval(*strongest, 2.0 * measurement.force_noise_N(), "N")),
                   within_N};
}

}  // namespace slipstack::workbench
