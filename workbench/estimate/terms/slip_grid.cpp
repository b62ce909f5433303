// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/terms/slip_grid.h"

#include <algorithm>
#include <cmath>

namespace slipstack::workbench {
namespace {

/// Smallest level assumed anywhere on the grid, relative to the largest: the virgin curve may be curved where
/// an effect that was not in the plain model has hidden it. Chosen.
constexpr double kLeastLevel = 0.05;
/// If the shortest element holds more than this share of the whole level, slip begins at shorter distances.
/// Chosen.
constexpr double kBeginsBelow = 0.02;
/// The shortest slip distance that slow motion between two encoder steps can show, in steps. Chosen.
constexpr double kShortestSteps = 0.25;

/// Non-negative least squares assign the level shared by neighbours to one of them; smoothing spreads it
/// again.
void smooth(std::vector<double>& levels) {
  const std::vector<double> was = levels;
  const std::size_t last = levels.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    levels[i] = 0.25 * was[i == 0 ? 0 : i - 1] + 0.5 * was[i] + 0.25 * was[std::min(i + 1, last)];
  }
}

}  // namespace

std::vector<double> refined_slip_distances(const Term& fitted, double encoder_resolution_m) {
  std::vector<double> slip_m = fitted.shapes;
  std::vector<double> levels(slip_m.size(), 0.0);
  double whole = 0.0;
  for (std::size_t i = 0; i < fitted.gains.size(); ++i) {
    const double level = fitted.gains[i] * slip_m[i % slip_m.size()];
    levels[i % slip_m.size()] += level;
    whole += level;
  }
  const bool even = std::is_sorted(slip_m.begin(), slip_m.end()) && slip_m.size() > 2 && slip_m.front() > 0.0;
  if (!even || !(whole > 0.0)) return slip_m;
  const double finest_m = kShortestSteps * encoder_resolution_m;
  const double ratio = slip_m[1] / slip_m[0];
  const double first = levels[0];
  while (first > kBeginsBelow * whole && slip_m.front() / ratio >= finest_m && slip_m.front() > 1e-9) {
    slip_m.insert(slip_m.begin(), slip_m.front() / ratio);
    levels.insert(levels.begin(), first);
  }
  smooth(levels);
  smooth(levels);
  const double least = kLeastLevel * *std::max_element(levels.begin(), levels.end());
  std::vector<double> corners{0.0};  // number of new distances below each of the old ones
  for (std::size_t i = 1; i < slip_m.size(); ++i) {
    const double level = std::max(least, 0.5 * (levels[i - 1] + levels[i]));
    corners.push_back(corners.back() + std::sqrt(level));
  }
  std::vector<double> refined;
  const std::size_t count = fitted.shapes.size();
  std::size_t at = 1;
  for (std::size_t k = 0; k < count; ++k) {
    const double wanted = corners.back() * static_cast<double>(k) / static_cast<double>(count - 1);
    while (at + 1 < corners.size() && corners[at] < wanted) ++at;
    const double t = (wanted - corners[at - 1]) / (corners[at] - corners[at - 1]);
    refined.push_back(slip_m[at - 1] * std::pow(slip_m[at] / slip_m[at - 1], std::clamp(t, 0.0, 1.0)));
  }
  return refined;
}

}  // namespace slipstack::workbench
