// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/loop_log.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

constexpr double kClosed = 0.05;  // of the height of the loop in position
constexpr double kSameAmplitude = 0.05;
constexpr double kSamePlace = 0.1;    // of the amplitude
constexpr std::size_t kBranch = 200;  // intervals per branch of an averaged loop

/// One closed loop: samples from a low turning point over a high one to the next low one.
struct Cycle {
  std::size_t begin = 0;
  std::size_t top = 0;
  std::size_t end = 0;
  double middle_m = 0.0;
  double amplitude_m = 0.0;
};

std::vector<Cycle> closed_cycles(std::span<const double> x, double threshold_m) {
  const std::vector<std::size_t> points = turning_points(x, threshold_m);
  std::vector<Cycle> cycles;
  for (std::size_t i = 0; i + 2 < points.size(); ++i) {
    const auto [a, b, c] = std::array{x[points[i]], x[points[i + 1]], x[points[i + 2]]};
    if (b <= a) continue;
    if (std::fabs(c - a) > kClosed * (b - std::min(a, c)) + threshold_m) continue;
    if (!cycles.empty() && cycles.back().end > points[i]) continue;
    const double low = 0.5 * (a + c);
    cycles.push_back({points[i], points[i + 1], points[i + 2], 0.5 * (b + low), 0.5 * (b - low)});
  }
  return cycles;
}

bool belong_together(const Cycle& a, const Cycle& b, double threshold_m) {
  return a.end == b.begin &&
         std::fabs(a.amplitude_m - b.amplitude_m) < kSameAmplitude * a.amplitude_m + 0.25 * threshold_m &&
         std::fabs(a.middle_m - b.middle_m) < kSamePlace * a.amplitude_m + threshold_m;
}

/// Force over position on one monotone branch, samples of equal position merged, at `nodes`.
std::vector<double> resampled(std::span<const double> x, std::span<const double> force, std::size_t begin,
                              std::size_t end, const std::vector<double>& nodes) {
  std::vector<std::size_t> order(end - begin + 1);
  std::iota(order.begin(), order.end(), begin);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return x[a] < x[b]; });
  std::vector<double> place;
  std::vector<double> mean;
  std::size_t weight = 0;
  for (const std::size_t i : order) {
    if (!place.empty() && x[i] == place.back()) {
      ++weight;
      mean.back() += (force[i] - mean.back()) / static_cast<double>(weight);
      continue;
    }
    weight = 1;
    place.push_back(x[i]);
    mean.push_back(force[i]);
  }
  std::vector<double> values;
  for (const double node : nodes) {
    const auto above = std::lower_bound(place.begin(), place.end(), node);
    const auto i = static_cast<std::size_t>(above - place.begin());
    if (i == 0 || i == place.size()) {
      values.push_back(i == 0 ? mean.front() : mean.back());
      continue;
    }
    const double share = (node - place[i - 1]) / (place[i] - place[i - 1]);
    values.push_back(mean[i - 1] + share * (mean[i] - mean[i - 1]));
  }
  return values;
}

/// A cycle on 2·kBranch points, dense at the tips, where the curve bends.
Loop shaped(std::span<const double> x, std::span<const double> force, const Cycle& cycle) {
  std::vector<double> nodes(kBranch + 1);
  for (std::size_t j = 0; j <= kBranch; ++j) {
    nodes[j] =
        cycle.middle_m - cycle.amplitude_m * std::cos(std::numbers::pi * static_cast<double>(j) / kBranch);
  }
  const std::vector<double> up = resampled(x, force, cycle.begin, cycle.top, nodes);
  const std::vector<double> down = resampled(x, force, cycle.top, cycle.end, nodes);
  Loop loop;
  for (std::size_t j = 0; j < kBranch; ++j) {
    loop.position_m.push_back(nodes[j]);
    loop.force_N.push_back(up[j]);
  }
  for (std::size_t j = kBranch; j > 0; --j) {
    loop.position_m.push_back(nodes[j]);
    loop.force_N.push_back(down[j]);
  }
  return loop;
}

AveragedLoop average(std::span<const double> x, std::span<const double> force, std::span<const Cycle> group,
                     std::size_t most) {
  if (group.size() >= 3) group = group.subspan(1);
  group = group.first(std::min(most, group.size()));
  AveragedLoop result;
  result.count = group.size();
  result.first_sample = group.front().begin;
  result.loop.position_m.assign(2 * kBranch, 0.0);
  result.loop.force_N.assign(2 * kBranch, 0.0);
  const double share = 1.0 / static_cast<double>(group.size());
  double sum = 0.0;
  double squares = 0.0;
  for (const Cycle& cycle : group) {
    const Loop single = shaped(x, force, cycle);
    for (std::size_t j = 0; j < single.position_m.size(); ++j) {
      result.loop.position_m[j] += share * single.position_m[j];
      result.loop.force_N[j] += share * single.force_N[j];
    }
    result.position_m += share * cycle.middle_m;
    const double ratio = figures_of(single).damping_ratio;
    sum += ratio;
    squares += ratio * ratio;
  }
  result.figures = figures_of(result.loop);
  if (group.size() > 1) {
    const double spread = (squares - sum * sum * share) / static_cast<double>(group.size() - 1);
    result.damping_ratio_spread = std::sqrt(std::max(0.0, spread));
  }
  return result;
}

}  // namespace

double motion_threshold_m(std::span<const double> position_m) {
  std::vector<double> thirds;
  double step_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 3; i < position_m.size(); ++i) {
    const double* p = position_m.data() + i;
    thirds.push_back(std::fabs(p[0] - 3.0 * p[-1] + 3.0 * p[-2] - p[-3]));
    const double moved = std::fabs(p[0] - p[-1]);
    if (moved > 0.0) step_m = std::min(step_m, moved);
  }
  if (thirds.empty() || !std::isfinite(step_m)) return 0.0;
  // Third differences of white noise have √20 times its deviation.
  const double noise_m = median(std::move(thirds)) / (kMedianOfNormal * std::sqrt(20.0));
  return std::max(8.0 * noise_m, 1.5 * step_m);
}

std::vector<std::size_t> turning_points(std::span<const double> position_m, double threshold_m) {
  std::vector<std::size_t> points;
  if (position_m.empty()) return points;
  points.push_back(0);
  std::size_t extreme = 0;
  int direction = 0;
  for (std::size_t i = 1; i < position_m.size(); ++i) {
    const double ahead = position_m[i] - position_m[extreme];
    if (direction == 0) {
      if (std::fabs(ahead) <= threshold_m) continue;
      direction = ahead > 0.0 ? 1 : -1;
      extreme = i;
    } else if (direction * ahead >= 0.0) {
      extreme = i;
    } else if (-direction * ahead > threshold_m) {
      points.push_back(extreme);
      direction = -direction;
      extreme = i;
    }
  }
  if (extreme != points.back()) points.push_back(extreme);
  return points;
}

std::vector<AveragedLoop> averaged_loops(std::span<const double> position_m, std::span<const double> force_N,
                                         std::size_t most) {
  if (position_m.size() != force_N.size()) throw std::invalid_argument("loops: sizes differ");
  const double threshold_m = motion_threshold_m(position_m);
  const std::vector<Cycle> cycles = closed_cycles(position_m, threshold_m);
  std::vector<AveragedLoop> loops;
  for (std::size_t begin = 0; begin < cycles.size();) {
    std::size_t end = begin + 1;
    while (end < cycles.size() && belong_together(cycles[end - 1], cycles[end], threshold_m)) ++end;
    // A single closed cycle is often the transition from one amplitude to the next.
    if (end - begin >= 2) {
      const std::span<const Cycle> group(cycles.data() + begin, end - begin);
      loops.push_back(average(position_m, force_N, group, most));
    }
    begin = end;
  }
  if (loops.empty()) {
    throw std::invalid_argument(
        "no closed loop was found twice in a row; record slow sines of constant amplitude, ten of each");
  }
  return loops;
}

}  // namespace slipstack::workbench
