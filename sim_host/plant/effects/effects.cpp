// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/effects/effects.h"

#include <cmath>

namespace slipstack::sim {

double Viscous::force_N(double velocity_mps) const {
  if (exponent == 1.0 || velocity_mps == 0.0) return coefficient_N_s_per_m * velocity_mps;
  return coefficient_N_s_per_m * velocity_mps * std::pow(std::fabs(velocity_mps) / 0.1, exponent - 1.0);
}

double QuadraticDrag::force_N(double velocity_mps) const {
  if (exponent == 2.0) return coefficient * velocity_mps * std::fabs(velocity_mps);
  return std::copysign(coefficient * std::pow(std::fabs(velocity_mps), exponent), velocity_mps);
}

std::string_view name(AccelerationLaw law) {
  switch (law) {
    case AccelerationLaw::kProportional:
      return "proportional";
    case AccelerationLaw::kSmooth:
      return "smooth_absolute";
    case AccelerationLaw::kSaturating:
      return "saturating";
  }
  return "unknown";
}

double AccelerationPreload::shape(double acceleration_mps2) const {
  const double magnitude = std::fabs(acceleration_mps2);
  switch (law) {
    case AccelerationLaw::kProportional:
      return magnitude;
    case AccelerationLaw::kSmooth:
      return std::hypot(magnitude, knee_mps2) - knee_mps2;
    case AccelerationLaw::kSaturating:
      return magnitude / (1.0 + magnitude / knee_mps2);
  }
  return 0.0;
}

std::string_view name(AsymmetryLaw law) {
  return law == AsymmetryLaw::kByForce ? "by_sign_of_force" : "by_sign_of_velocity";
}

double DirectionAsymmetry::factor(double hysteresis_N, double saturation_N, double velocity_mps) const {
  const double argument =
      law == AsymmetryLaw::kByForce ? 20.0 * hysteresis_N / saturation_N : velocity_mps / 0.5e-3;
  return 1.0 + level * std::tanh(argument);
}

double CableChain::force_N(double x_m) const {
  const double u = x_m - rest_m;
  return stiffness_N_per_m * u * (1.0 + stiffening * (u / stroke_m) * (u / stroke_m));
}

std::string_view name(DriftKind kind) {
  switch (kind) {
    case DriftKind::kWarming:
      return "exponential_warming";
    case DriftKind::kLinear:
      return "linear";
    case DriftKind::kRunIn:
      return "run_in";
    case DriftKind::kCreep:
      return "logarithmic_creep";
  }
  return "unknown";
}

std::string_view name(DriftTarget target) {
  switch (target) {
    case DriftTarget::kHysteresis:
      return "hysteresis";
    case DriftTarget::kViscous:
      return "viscous";
    case DriftTarget::kBoth:
      return "hysteresis_and_viscous";
  }
  return "unknown";
}

double Drift::factor(double t_s) const {
  const double u = t_s / time_s;
  switch (kind) {
    case DriftKind::kWarming:
      return 1.0 - depth * std::expm1(-u);
    case DriftKind::kLinear:
      return 1.0 + depth * u;
    case DriftKind::kRunIn:
      return 1.0 + depth * (1.0 / (1.0 + u) - 1.0);
    case DriftKind::kCreep:
      return 1.0 + depth * std::log1p(u);
  }
  return 1.0;
}

double ForceFilter::half_Hz() const {
  // |H|² of one pass is 1 / (1 + (f/cut)^(2 order)): a half of |H| where that is a quarter.
  return zero_phase ? cut_Hz : cut_Hz * std::pow(3.0, 0.5 / order);
}

}  // namespace slipstack::sim
