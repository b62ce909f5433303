// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/describing_function.h"
#include "sim_host/gauss_legendre.h"

#include <cmath>
#include <numbers>

namespace slipstack::sim {
namespace {

constexpr double kPi = std::numbers::pi;

template <typename Function>
double panel(double from, double to, Function function) {
  const double middle = 0.5 * (from + to);
  const double half = 0.5 * (to - from);
  double sum = 0.0;
  for (std::size_t i = 0; i < kGaussNodes.size(); ++i) {
    sum += kGaussWeights[i] *
           (function(middle - half * kGaussNodes[i]) + function(middle + half * kGaussNodes[i]));
  }
  return half * sum;
}

// ∫ from 0 to `to`, panels growing by two from where the integrand may be steep.
template <typename Function>
double graded(double to, Function function) {
  double sum = 0.0;
  double high = to;
  for (int i = 0; i < 26; ++i) {
    const double low = 0.5 * high;
    // Two panels each: the loop may bend sharply anywhere when its amplitude is far beyond the curve's
    // length.
    sum += panel(low, 0.75 * high, function) + panel(0.75 * high, high, function);
    high = low;
  }
  return sum + panel(0.0, high, function);
}

}  // namespace

Equivalent equivalent(const VirginCurve& curve, double amplitude_m) {
  const double a = amplitude_m;
  const double tip_N = curve.force_N(a);
  // The upper branch backwards: x = A·cos θ, F = y(A) − 2·y(A·(1 − cos θ)/2), θ = 0 … π. F(θ + π) = −F(θ).
  const auto branch_N = [&](double theta) {
    const double s = std::sin(0.5 * theta);
    return tip_N - 2.0 * curve.force_N(a * s * s);
  };
  Equivalent out;
  out.stiffness_N_per_m =
      2.0 / (kPi * a) * graded(kPi, [&](double theta) { return branch_N(theta) * std::cos(theta); });
  out.area_J = 8.0 * graded(a, [&](double x) { return curve.force_N(x); }) - 4.0 * a * tip_N;
  out.damping_N_per_m = out.area_J / (kPi * a * a);
  out.tip_stiffness_N_per_m = tip_N / a;
  out.resonance_damping_ratio = out.area_J / (2.0 * kPi * a * tip_N);
  return out;
}

std::complex<double> dynamic_stiffness(const ExperimentSetup& setup, double rad_per_s) {
  const double w = rad_per_s;
  const Effects& effects = setup.axis.effects;
  const double mass_kg = setup.axis.mass_kg + effects.payload_kg.value_or(0.0);
  std::complex<double> stiffness(-mass_kg * w * w, 0.0);
  if (effects.viscous) stiffness += std::complex<double>(0.0, effects.viscous->coefficient_N_s_per_m * w);
  if (effects.cable) stiffness += effects.cable->stiffness_N_per_m;
  if (effects.resonance) {
    // The arm moves relative to the carriage by q = ω²x/(ω₂² − ω² + 2iζω₂ω) and acts on it with m₂·ω²·(x +
    // q).
    const Resonance& arm = *effects.resonance;
    const double w2 = arm.frequency_rad_per_s;
    const std::complex<double> q =
        w * w / std::complex<double>(w2 * w2 - w * w, 2.0 * arm.damping_ratio * w2 * w);
    stiffness -= arm.ratio * setup.axis.mass_kg * w * w * q;
  }
  return stiffness;
}

DescribedPoint describe_response(const ExperimentSetup& setup, double force_N, double frequency_Hz) {
  const double w = 2.0 * kPi * frequency_Hz;
  const std::complex<double> linear = dynamic_stiffness(setup, w);
  const auto whole = [&](double amplitude_m) {
    const Equivalent loop = equivalent(setup.axis.curve, amplitude_m);
    return linear + std::complex<double>(loop.stiffness_N_per_m, loop.damping_N_per_m);
  };
  const auto surplus_N = [&](double log_a) {
    const double a = std::exp(log_a);
    return std::abs(whole(a)) * a - force_N;
  };
  DescribedPoint point;
  point.frequency_Hz = frequency_Hz;
  // From far below the curve's length to beyond the stroke; sign changes between neighbours are solutions.
  const double low = std::log(1e-7 * setup.axis.curve.travel_m());
  const double high = std::log(std::max(10.0 * setup.axis.stroke_m, 1e3 * setup.axis.curve.travel_m()));
  constexpr int kCells = 160;
  double from = low;
  double at_from = surplus_N(from);
  double first = 0.0;
  for (int i = 1; i <= kCells; ++i) {
    const double to = low + (high - low) * i / kCells;
    const double at_to = surplus_N(to);
    if ((at_from < 0.0) != (at_to < 0.0)) {
      if (point.solutions++ == 0) {
        double a = from;
        double b = to;
        for (int k = 0; k < 60; ++k) {
          const double middle = 0.5 * (a + b);
          ((surplus_N(middle) < 0.0) == (at_from < 0.0) ? a : b) = middle;
        }
        first = std::exp(0.5 * (a + b));
      }
    }
    from = to;
    at_from = at_to;
  }
  if (point.solutions == 0) return point;
  point.amplitude_m = first;
  point.phase_rad = -std::arg(whole(first));
  if (point.phase_rad > 0.5 * kPi) point.phase_rad -= 2.0 * kPi;
  return point;
}

}  // namespace slipstack::sim
