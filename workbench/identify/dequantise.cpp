// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/dequantise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace slipstack::workbench {
namespace {

/// An instant, in samples, at which the position is known.
struct Knot {
  double time;
  double position_m;
};

/// Crossings of cell borders, half-way between the two readings; with several cells in one sample, their
/// middle. The ends of the record are knots as read.
std::vector<Knot> crossings(std::span<const double> position_m) {
  std::vector<Knot> knots{{0.0, position_m.front()}};
  for (std::size_t i = 1; i < position_m.size(); ++i) {
    if (position_m[i] == position_m[i - 1]) continue;
    knots.push_back({static_cast<double>(i) - 0.5, 0.5 * (position_m[i] + position_m[i - 1])});
  }
  knots.push_back({static_cast<double>(position_m.size() - 1), position_m.back()});
  return knots;
}

/// Slope at each knot: of the parabola through it and its neighbours.
std::vector<double> slopes(const std::vector<Knot>& knots) {
  std::vector<double> slope(knots.size(), 0.0);
  for (std::size_t k = 1; k + 1 < knots.size(); ++k) {
    const double before = knots[k].time - knots[k - 1].time;
    const double after = knots[k + 1].time - knots[k].time;
    if (before <= 0.0 || after <= 0.0) continue;
    const double in = (knots[k].position_m - knots[k - 1].position_m) / before;
    const double out = (knots[k + 1].position_m - knots[k].position_m) / after;
    slope[k] = (in * after + out * before) / (before + after);
  }
  return slope;
}

}  // namespace

std::vector<double> dequantise(std::span<const double> position_m, double resolution_m) {
  std::vector<double> smooth(position_m.begin(), position_m.end());
  if (resolution_m <= 0.0 || position_m.size() < 3) return smooth;
  const std::vector<Knot> knots = crossings(position_m);
  const std::vector<double> slope = slopes(knots);
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const double length = knots[k + 1].time - knots[k].time;
    // A cell crossed within two samples tells no more than its readings.
    if (length < 2.0) continue;
    for (auto i = static_cast<std::size_t>(std::ceil(knots[k].time));
         i < smooth.size() && static_cast<double>(i) < knots[k + 1].time; ++i) {
      const double t = (static_cast<double>(i) - knots[k].time) / length;
      const double u = 1.0 - t;
      const double cubic = knots[k].position_m * u * u * (1.0 + 2.0 * t) +
                           knots[k + 1].position_m * t * t * (3.0 - 2.0 * t) +
                           length * t * u * (slope[k] * u - slope[k + 1] * t);
      smooth[i] = std::clamp(cubic, position_m[i] - 0.5 * resolution_m, position_m[i] + 0.5 * resolution_m);
    }
  }
  return smooth;
}

}  // namespace slipstack::workbench
