// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/guideway.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

double sine_squared(const BallContact& contact) {
  const double sine = std::sin(0.5 * contact.groove_angle_deg * std::numbers::pi / 180.0);
  return sine * sine;
}

/// Exact for a polygon, whose corners a quadrature rule would miss.
double damping_ratio(const PolygonCurve& curve, double amplitude_m) {
  double integral = 0.0;
  double x0 = 0.0;
  double y0 = 0.0;
  for (std::size_t i = 0; i < curve.displacement_m.size() && x0 < amplitude_m; ++i) {
    const double x1 = std::min(curve.displacement_m[i], amplitude_m);
    const double y1 = curve.force_at_N(x1);
    integral += 0.5 * (y0 + y1) * (x1 - x0);
    x0 = x1;
    y0 = y1;
  }
  integral += y0 * (amplitude_m - x0);
  const double area = 8.0 * integral - 4.0 * amplitude_m * curve.force_at_N(amplitude_m);
  return area / (2.0 * std::numbers::pi * amplitude_m * curve.force_at_N(amplitude_m));
}

/// Mean logarithm of ζᵣ(A/scale)/ζᵣ(A) over three to nine tenths of the reach: below, the curve consists of
/// single elements of the fit.
double mean_gain(const PolygonCurve& curve, double scale) {
  constexpr int kPlaces = 24;
  double sum = 0.0;
  int used = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const double amplitude_m = curve.reach_m() * (0.3 + 0.6 * i / (kPlaces - 1));
    const double now = damping_ratio(curve, amplitude_m);
    const double then = damping_ratio(curve, amplitude_m / scale);
    if (!(now > 0.0) || !(then > 0.0)) continue;
    sum += std::log(then / now);
    ++used;
  }
  return used > 0 ? sum / used : 0.0;
}

}  // namespace

std::string_view name(BallMaterial material) {
  switch (material) {
    case BallMaterial::kSteel:
      return "steel";
    case BallMaterial::kSiliconNitride:
      return "silicon_nitride";
    case BallMaterial::kDiamondCoated:
      return "diamond_coated";
  }
  return "unknown";
}

std::optional<BallMaterial> ball_material(std::string_view word) {
  for (const BallMaterial material :
       {BallMaterial::kSteel, BallMaterial::kSiliconNitride, BallMaterial::kDiamondCoated}) {
    if (word == name(material)) return material;
  }
  return std::nullopt;
}

void check(const BallContact& contact) {
  if (!(contact.load_per_ball_N > 0.0)) throw std::invalid_argument("the load per ball must be positive");
  if (!(contact.groove_angle_deg > 0.0 && contact.groove_angle_deg <= 180.0)) {
    throw std::invalid_argument("the groove angle must lie between 0 and 180 degrees");
  }
  if (!(contact.ball_diameter_m > 0.0)) throw std::invalid_argument("the ball diameter must be positive");
  if (!(contact.balls > 0.0)) throw std::invalid_argument("the number of balls must be positive");
}

Scaling scaling(const BallContact& from, const BallContact& to) {
  check(from);
  check(to);
  const double angle = sine_squared(to) / sine_squared(from);
  Scaling factors;
  factors.force = std::sqrt(to.load_per_ball_N / from.load_per_ball_N) / angle * to.balls / from.balls;
  factors.displacement = std::sqrt(to.ball_diameter_m / from.ball_diameter_m) * angle;
  return factors;
}

double material_scale(const PolygonCurve& curve, BallMaterial from, BallMaterial to) {
  const auto is_steel = [](BallMaterial material) { return material == BallMaterial::kSteel; };
  if (is_steel(from) == is_steel(to)) return 1.0;
  const double wanted = std::log(is_steel(from) ? 1.0 / kSteelDampingShare : kSteelDampingShare);
  // A shorter travel (scale < 1) raises ζᵣ at every amplitude.
  double low = 0.05;
  double high = 20.0;
  if (mean_gain(curve, low) < wanted || mean_gain(curve, high) > wanted) {
    throw std::invalid_argument(
        "the damping ratio of this loop hardly changes with amplitude, so a change of material cannot be "
        "read "
        "from it; record a loop that reaches further towards rolling");
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(low * high);
    (mean_gain(curve, middle) > wanted ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

Loop scaled(const Loop& loop, const Scaling& factors) {
  Loop result = loop;
  for (double& x : result.position_m) x *= factors.displacement;
  for (double& force : result.force_N) force *= factors.force;
  return result;
}

GuidewayPrediction predict(const Loop& measured, const PolygonCurve& curve, const BallContact& from,
                           const BallContact& to, double force_ratio) {
  if (!(force_ratio > 0.0)) throw std::invalid_argument("the force ratio of the materials must be positive");
  GuidewayPrediction result;
  result.scaling = scaling(from, to);
  result.scaling.displacement *= material_scale(curve, from.material, to.material);
  result.scaling.force *= force_ratio;
  result.curve = curve;
  for (double& x : result.curve.displacement_m) x *= result.scaling.displacement;
  for (double& force : result.curve.force_N) force *= result.scaling.force;
  result.loop = scaled(measured, result.scaling);
  result.figures = figures_of(result.loop);
  result.initial_stiffness_N_per_m = result.curve.initial_stiffness_N_per_m();
  return result;
}

Loop masing_loop(const PolygonCurve& curve, double amplitude_m, std::size_t half) {
  const double tip_N = curve.force_at_N(amplitude_m);
  Loop loop;
  for (std::size_t i = 0; i < 2 * half; ++i) {
    const bool rising = i < half;
    const double phase = std::numbers::pi * static_cast<double>(i) / static_cast<double>(half);
    const double x = -amplitude_m * std::cos(phase);
    loop.position_m.push_back(x);
    loop.force_N.push_back(rising ? -tip_N + 2.0 * curve.force_at_N(0.5 * (x + amplitude_m))
                                  : tip_N - 2.0 * curve.force_at_N(0.5 * (amplitude_m - x)));
  }
  return loop;
}

double loop_spread(const std::vector<Loop>& loops) {
  if (loops.size() < 2) return 0.0;
  std::vector<std::vector<VirginSample>> curves;
  double reach_m = std::numeric_limits<double>::infinity();
  for (const Loop& loop : loops) {
    std::vector<VirginSample> samples = virgin_samples(loop);
    std::sort(samples.begin(), samples.end(), [](const VirginSample& a, const VirginSample& b) {
      return a.displacement_m < b.displacement_m;
    });
    reach_m = std::min(reach_m, samples.back().displacement_m);
    curves.push_back(std::move(samples));
  }
  const auto value = [](const std::vector<VirginSample>& samples, double x) {
    const auto above = std::lower_bound(
        samples.begin(), samples.end(), x,
        [](const VirginSample& sample, double place) { return sample.displacement_m < place; });
    if (above == samples.begin()) return above->force_N;
    const VirginSample& a = *(above - 1);
    const VirginSample& b = above == samples.end() ? a : *above;
    const double gap = b.displacement_m - a.displacement_m;
    return gap > 0.0 ? a.force_N + (b.force_N - a.force_N) * (x - a.displacement_m) / gap : a.force_N;
  };
  constexpr int kPlaces = 50;
  double squares = 0.0;
  double largest = 0.0;
  for (int i = 1; i <= kPlaces; ++i) {
    const double x = reach_m * i / kPlaces;
    double mean = 0.0;
    for (const auto& curve : curves) mean += value(curve, x) / static_cast<double>(curves.size());
    for (const auto& curve : curves) squares += squared(value(curve, x) - mean);
    largest = std::max(largest, mean);
  }
  return std::sqrt(squares / (kPlaces * static_cast<double>(loops.size()))) / largest;
}

}  // namespace slipstack::workbench
