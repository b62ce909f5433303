// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/turning_points.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace slipstack::workbench {
namespace {

/// A turning point is taken from the parabola through three samples where it bends by so many encoder steps:
/// then the parabola's top is known better than the step ...
constexpr double kCurvedSteps = 16.0;
/// ... and where it bends as much one sample before and one after, within this share: a move that ends
/// between two samples has no top beyond them.
constexpr double kSteadyCurvature = 0.5;
/// Each leg of a zigzag is longer than this share of a step: half-way between what rounding leaves and it.
constexpr double kLeastLeg = 0.4;

/// How a displacement bends at its sample `x[0]` and at those beside it; read from x[-2] to x[2].
struct Bends {
  explicit Bends(const double* x)
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

/// How far a zigzag came, none where its legs are no more than rounding.
std::optional<double> corner_m(const double* x, const Bends& bends, double step_m, double beyond_corners) {
  const double least_m = std::min(
      {std::abs(x[0] - x[-1]), std::abs(x[1] - x[0]), std::abs(bends.before_m), std::abs(bends.after_m)});
  if (beyond_corners <= 0.0 || least_m <= kLeastLeg * step_m) return std::nullopt;
  return x[0] - 0.5 * beyond_corners * bends.here_m;
}

/// The turn of an axis that turns round at sample `i`, before it or after.
std::optional<TurningPoint> turning_point_at(std::size_t i, const double* x, double step_m,
                                             double beyond_corners) {
  const Bends bends(x);
  if (bends.zigzag()) {
    const std::optional<double> corner = corner_m(x, bends, step_m, beyond_corners);
    return corner ? std::optional<TurningPoint>({i, *corner}) : std::nullopt;
  }
  if (std::abs(bends.here_m) < kCurvedSteps * step_m || !bends.steady()) return std::nullopt;
  const double slope_m = 0.5 * (x[1] - x[-1]);
  const bool later = slope_m * bends.here_m < 0.0;
  return TurningPoint{later ? i + 1 : i, x[0] - slope_m * slope_m / (2.0 * bends.here_m)};
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
