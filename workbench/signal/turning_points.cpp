// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/turning_points.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace slipstack::workbench {
namespace {

/// The turning point is the vertex of the parabola through three samples where their second difference is at
/// least so many encoder steps: the vertex is then known more accurately than by one step. Chosen.
constexpr double kCurvedSteps = 16.0;
/// The second differences one sample before and after must agree with it within this share: a move that ends
/// between two samples has no vertex beyond them. Chosen.
constexpr double kSteadyCurvature = 0.5;
/// Each leg of a zigzag is longer than this share of a step. Rounding of decimals leaves nearly zero, a true
/// move of the encoder a whole step: chosen between the two.
constexpr double kLeastLeg = 0.4;

/// Second differences of a displacement at its sample `x[0]` and at the two beside it; reads x[-2] to x[2].
struct SecondDifferences {
  explicit SecondDifferences(const double* x)
      : here_m(x[-1] - 2.0 * x[0] + x[1]),
        before_m(x[-2] - 2.0 * x[-1] + x[0]),
        after_m(x[0] - 2.0 * x[1] + x[2]) {}
  bool zigzag() const { return before_m * here_m < 0.0 && after_m * here_m < 0.0; }
  bool steady() const {
    return std::abs(before_m - here_m) <= kSteadyCurvature * std::abs(here_m) &&
           std::abs(after_m - here_m) <= kSteadyCurvature * std::abs(here_m);
  }
  double here_m;
  double before_m;
  double after_m;
};

/// The displacement that a zigzag reached; none where its legs are no longer than rounding makes them.
std::optional<double> corner_m(const double* x, const SecondDifferences& second, double step_m,
                               double beyond_corners) {
  const double least_m = std::min(
      {std::abs(x[0] - x[-1]), std::abs(x[1] - x[0]), std::abs(second.before_m), std::abs(second.after_m)});
  if (beyond_corners <= 0.0 || least_m <= kLeastLeg * step_m) return std::nullopt;
  return x[0] - 0.5 * beyond_corners * second.here_m;
}

/// The turning point near sample `i`, where the steps before and after have opposite signs.
std::optional<TurningPoint> turning_point_at(std::size_t i, const double* x, double step_m,
                                             double beyond_corners) {
  const SecondDifferences second(x);
  if (second.zigzag()) {
    const std::optional<double> corner = corner_m(x, second, step_m, beyond_corners);
    return corner ? std::optional<TurningPoint>({i, *corner}) : std::nullopt;
  }
  if (std::abs(second.here_m) < kCurvedSteps * step_m || !second.steady()) return std::nullopt;
  const double slope_m = 0.5 * (x[1] - x[-1]);
  const bool later = slope_m * second.here_m < 0.0;
  return TurningPoint{later ? i + 1 : i, x[0] - slope_m * slope_m / (2.0 * second.here_m)};
}

}  // namespace

void find_turning_points(const std::vector<double>& displacement_m, Interval samples, double step_m,
                         double beyond_corners, std::vector<TurningPoint>& found) {
  if (!(step_m > 0.0)) return;
  for (std::size_t i = samples.first + 2; i + 2 < samples.end; ++i) {
    const double* const x = &displacement_m[i];
    if ((x[0] - x[-1]) * (x[1] - x[0]) >= 0.0) continue;
    if (const auto point = turning_point_at(i, x, step_m, beyond_corners)) found.push_back(*point);
  }
}

}  // namespace slipstack::workbench
