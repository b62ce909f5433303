// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/bursts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/interval.h"
#include "workbench/base/quantity.h"
#include "workbench/cleaning/outliers.h"
#include "workbench/diagnose/evidence/chance.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// The absolute deviation of each sample of a force from the cubic through its neighbours, part by part.
std::vector<double> jumps_of(const Measurement& measurement, const std::vector<double>& force_N) {
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

/// By how much each sample of the measured force deviates more than the model's.
std::vector<double> jumps_beyond(const Measurement& measurement, const std::vector<double>& model_N) {
  std::vector<double> jumps_N = jumps_of(measurement, measurement.log().force_N);
  const std::vector<double> expected_N = jumps_of(measurement, model_N);
  for (std::size_t i = 0; i < jumps_N.size(); ++i) jumps_N[i] = std::max(0.0, jumps_N[i] - expected_N[i]);
  return jumps_N;
}

/// So many deviations follow one cause, because each consists of so many samples.
constexpr auto kSamplesOfDeviation = static_cast<double>(kSamplesOfDeparture);

/// The natural logarithm of the probability that, of `all` samples, the `count` with the largest deviations
/// lie within an interval of `length` samples by chance: k (L/N)^(k-1) for k independent ones (Naus 1965, The
/// distribution of the size of the maximum cluster of points on a line).
double ln_chance_of_cluster(std::size_t count, std::size_t length, std::size_t all) {
  const double independent = static_cast<double>(count) / kSamplesOfDeviation;
  if (independent <= 1.0) return 0.0;
  return std::log(independent) +
         (independent - 1.0) * std::log(static_cast<double>(length) / static_cast<double>(all));
}

/// Whether some of these places are so far apart, for as many within an interval, that they are not of one
/// burst: chance leaves a gap of the share g free with the probability k (1 - g)^(k - 1) at most (Darling
/// 1953).
bool fall_apart(std::vector<std::size_t> places) {
  std::sort(places.begin(), places.end());
  std::size_t gap = 0;
  for (std::size_t i = 1; i < places.size(); ++i) gap = std::max(gap, places[i] - places[i - 1]);
  const double independent = static_cast<double>(places.size()) / kSamplesOfDeviation;
  const auto length = static_cast<double>(places.back() - places.front());
  return !is_chance(std::pow(1.0 - static_cast<double>(gap) / length, independent - 1.0), independent);
}

/// The interval in which the largest deviations lie, for as many of them as are least likely there by chance;
/// empty where that is chance, or where they are not of one burst.
Interval noisy_interval(const std::vector<double>& jumps_N) {
  std::vector<std::size_t> order(jumps_N.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return jumps_N[a] > jumps_N[b]; });
  Interval spanned{order.front(), order.front() + 1};
  Interval least_likely;
  std::size_t count = 0;
  double ln_least = 0.0;
  for (std::size_t i = 0; i < order.size() && jumps_N[order[i]] > 0.0; ++i) {
    spanned.first = std::min(spanned.first, order[i]);
    spanned.end = std::max(spanned.end, order[i] + 1);
    if (static_cast<double>(spanned.size()) > kMajority * static_cast<double>(order.size())) break;
    const double ln_chance = ln_chance_of_cluster(i + 1, spanned.size(), order.size());
    if (ln_chance >= ln_least) continue;
    ln_least = ln_chance;
    least_likely = spanned;
    count = i + 1;
  }
  if (is_chance(std::exp(ln_least), static_cast<double>(order.size()))) return {};
  order.resize(count);
  return fall_apart(std::move(order)) ? Interval{} : least_likely;
}

/// The largest magnitude within an interval, and of the other samples.
struct Extremes {
  double within = 0.0;
  double without = 0.0;
};
Extremes extremes(const std::vector<double>& values, const Interval& interval) {
  Extremes most;
  for (std::size_t i = 0; i < values.size(); ++i) {
    double& own = i >= interval.first && i < interval.end ? most.within : most.without;
    own = std::max(own, std::abs(values[i]));
  }
  return most;
}

}  // namespace

std::optional<Structure> burst_in_force(const Measurement& measurement, const std::vector<double>& model_N,
                                        const Eigen::VectorXd& residual_N) {
  const std::vector<double> jumps_N = jumps_beyond(measurement, model_N);
  if (jumps_N.empty()) return {};
  const Interval burst = noisy_interval(jumps_N);
  if (burst.size() == 0) return {};
  const double largest_N = extremes(jumps_N, burst).within;
  // The only fast move of a log changes the force quickly too.
  const Extremes acceleration = extremes(measurement.acceleration_mps2(), burst);
  if (acceleration.within > acceleration.without) return {};
  const double first_s = measurement.time_s(burst.first);
  const double end_s = measurement.time_s(burst.end - 1);
  const double sample_s = measurement.tick_s();
  const Eigen::VectorXd times = row_times(measurement);
  const Eigen::VectorXd within_N =
      ((times.array() >= first_s) && (times.array() <= end_s)).select(residual_N.array(), 0.0);
  const double share = within_N.squaredNorm() / std::max(residual_N.squaredNorm(), 1e-300);
  return Structure{Coordinate::time, reduction_beyond(share, 0.0), first_s,
                   fmt::format("the {} jumps about for {} at {}, by {}, as nowhere else in the log: look "
                               "for a loose plug, a disturbed sensor or a knock",
                               force_word(), quantity_with_interval(end_s - first_s, sample_s, "s"),
                               when_of(measurement, first_s, sample_s),
                               quantity_with_interval(largest_N, 2.0 * measurement.force_noise_N(), "N")),
                   within_N};
}

}  // namespace slipstack::workbench
