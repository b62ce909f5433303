// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/loop_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace slipstack::workbench {
namespace {

using std::numbers::pi;

/// Of the sum of the areas below a loop's chords, a few hundred of them, over amplitude times force.
constexpr double kRounding = 1e-12;

void derive(LoopFigures& figures) {
  const double A = figures.amplitude_m;
  figures.stiffness_N_per_m = figures.force_N / A;
  figures.damping_N_per_m = figures.area_J / (pi * A * A);
  figures.damping_ratio = figures.area_J / (2.0 * pi * A * figures.force_N);
}

/// a₁/A = (1/πA)·∮ F·cos θ dθ with x = centre + A·cos θ: trapezoids over the phase that follows from each
/// point's position, forwards on the falling branch and backwards on the rising one.
double fundamental(const Loop& loop, double centre_m, double amplitude_m) {
  const std::size_t count = loop.position_m.size();
  const auto phase = [&](std::size_t i) {
    return std::acos(std::clamp((loop.position_m[i] - centre_m) / amplitude_m, -1.0, 1.0));
  };
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = (i + 1) % count;
    const double from = phase(i);
    const double to = phase(next);
    // Falling, θ grows from 0 to π; rising it goes on from π to 2π, where acos runs backwards.
    const double step = std::fabs(to - from);
    sum += 0.5 * (loop.force_N[i] * std::cos(from) + loop.force_N[next] * std::cos(to)) * step;
  }
  return sum / (pi * amplitude_m);
}

}  // namespace

LoopFigures figures_of(const Loop& loop) {
  const std::size_t count = loop.position_m.size();
  if (count < 8 || loop.force_N.size() != count) {
    throw std::invalid_argument("a loop needs at least eight points, a force with each");
  }
  const auto [low, high] = std::minmax_element(loop.position_m.begin(), loop.position_m.end());
  const auto force_at = [&](auto place) {
    return loop.force_N[static_cast<std::size_t>(place - loop.position_m.begin())];
  };
  LoopFigures figures;
  figures.amplitude_m = 0.5 * (*high - *low);
  figures.force_N = 0.5 * (force_at(high) - force_at(low));
  const double centre_m = 0.5 * (*high + *low);
  double area = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = (i + 1) % count;
    area += 0.5 * (loop.force_N[i] + loop.force_N[next]) * (loop.position_m[next] - loop.position_m[i]);
  }
  figures.area_J = std::max(0.0, area);
  if (!(figures.amplitude_m > 0.0) || !(figures.force_N > 0.0)) {
    throw std::invalid_argument("a loop without extent: position and force must both move, the same way");
  }
  // The area of a straight line is zero but for rounding, of either sign.
  if (!(area > -kRounding * figures.amplitude_m * figures.force_N)) {
    throw std::invalid_argument(
        "a loop that releases energy instead of dissipating it; check the sign of force or position");
  }
  derive(figures);
  figures.fundamental_stiffness_N_per_m = fundamental(loop, centre_m, figures.amplitude_m);
  return figures;
}

LoopFigures figures_of_virgin(const std::function<double(double)>& virgin_N, double amplitude_m) {
  if (!(amplitude_m > 0.0)) throw std::invalid_argument("the amplitude of a loop must be positive");
  LoopFigures figures;
  figures.amplitude_m = amplitude_m;
  figures.force_N = virgin_N(amplitude_m);
  if (!(figures.force_N > 0.0)) throw std::invalid_argument("a virgin curve must rise from zero");
  // Simpson's rule over t with x = A·t⁴: flat where a power law is steep.
  constexpr int kPanels = 2000;
  double integral = 0.0;
  for (int i = 0; i <= kPanels; ++i) {
    const double t = static_cast<double>(i) / kPanels;
    const double weight = i == 0 || i == kPanels ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    integral += weight * virgin_N(amplitude_m * t * t * t * t) * 4.0 * t * t * t;
  }
  integral *= amplitude_m / (3.0 * kPanels);
  figures.area_J = 8.0 * integral - 4.0 * amplitude_m * figures.force_N;
  // a₁ = (4/π)·∫₀^π y(A(1 + cos θ)/2)·cos θ dθ ([2], eq. 9); the midpoint rule on a periodic integrand.
  double a1 = 0.0;
  for (int i = 0; i < kPanels; ++i) {
    const double theta = pi * (i + 0.5) / kPanels;
    a1 += virgin_N(0.5 * amplitude_m * (1.0 + std::cos(theta))) * std::cos(theta);
  }
  figures.fundamental_stiffness_N_per_m = 4.0 * a1 / (kPanels * amplitude_m);
  derive(figures);
  return figures;
}

double RationalCurve::force_N(double displacement_m) const {
  const double u = displacement_m / length_m;
  return level_N * u * (2.0 + u) / ((1.0 + u) * (1.0 + u));
}

LoopFigures RationalCurve::closed_form(double amplitude_m) const {
  const double A = amplitude_m;
  LoopFigures figures;
  figures.amplitude_m = A;
  figures.force_N = force_N(A);
  figures.stiffness_N_per_m = figures.force_N / A;
  figures.damping_N_per_m = 4.0 * level_N * A / (pi * (A + length_m) * (A + length_m));
  figures.damping_ratio = 2.0 / pi * A / (A + 2.0 * length_m);
  figures.area_J = figures.damping_N_per_m * pi * A * A;
  return figures;
}

double power_law_damping_ratio(double exponent) {
  return 2.0 / pi * (1.0 - exponent) / (1.0 + exponent);
}

}  // namespace slipstack::workbench
