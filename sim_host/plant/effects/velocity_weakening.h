// SPDX-License-Identifier: Apache-2.0
// Stribeck curves, and friction that follows its Stribeck curve late.
#pragma once

#include <string_view>

namespace slipstack::sim {

enum class WeakeningKind { kGaussian, kTustin, kLorentzian, kBoPavelescu, kHyperbolic };
std::string_view name(WeakeningKind kind);

/// Friction level over steady velocity, relative to the level at rest: s(v) = 1 − depth·(1 − g(|v|/v_s)) with
///   gaussian     g = exp(−r²)              tustin      g = exp(−r)
///   lorentzian   g = 1/(1 + r²) (Hess and Soom 1990)
///   bo_pavelescu g = exp(−r^exponent) (Bo and Pavelescu 1982)   hyperbolic g = 1/(1 + r)
struct WeakeningCurve {
  WeakeningKind kind = WeakeningKind::kGaussian;
  double depth = 0.0;  // 0 … 1
  double velocity_mps = 0.01;
  double exponent = 1.0;

  double level(double velocity) const;
};

enum class LagKind { kTime, kDistance, kAttraction };
std::string_view name(LagKind kind);

/// A level λ that follows s(v) with delay:
///   time        dλ/dt = (s(v) − λ)/τ                          (first-order lag)
///   distance    dλ/dt = |v|·(s(v) − λ)/L                      (contacts renewed over a sliding distance)
///   attraction  dλ/dt = C·(1 − λ/s(v))                        (slip dynamics of the GMS model, [4])
struct FrictionalLag {
  LagKind kind = LagKind::kTime;
  WeakeningCurve curve;
  double time_s = 0.02;
  double distance_m = 1e-3;
  double attraction_per_s = 50.0;

  /// dλ/dt = rate·(target − λ): the two numbers of that line for a velocity.
  struct Relaxation {
    double rate_per_s;
    double target;
  };
  Relaxation relaxation(double velocity) const;
};

}  // namespace slipstack::sim
