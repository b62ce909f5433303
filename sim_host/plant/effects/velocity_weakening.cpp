// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/effects/velocity_weakening.h"

#include <cmath>

namespace slipstack::sim {

std::string_view name(WeakeningKind kind) {
  switch (kind) {
    case WeakeningKind::kGaussian:
      return "gaussian";
    case WeakeningKind::kTustin:
      return "tustin_exponential";
    case WeakeningKind::kLorentzian:
      return "lorentzian";
    case WeakeningKind::kBoPavelescu:
      return "bo_pavelescu";
    case WeakeningKind::kHyperbolic:
      return "hyperbolic";
  }
  return "unknown";
}

std::string_view name(LagKind kind) {
  switch (kind) {
    case LagKind::kTime:
      return "first_order_in_time";
    case LagKind::kDistance:
      return "first_order_in_distance";
    case LagKind::kAttraction:
      return "gms_attraction";
  }
  return "unknown";
}

double WeakeningCurve::level(double velocity) const {
  const double r = std::fabs(velocity) / velocity_mps;
  double g = 1.0;
  switch (kind) {
    case WeakeningKind::kGaussian:
      g = std::exp(-r * r);
      break;
    case WeakeningKind::kTustin:
      g = std::exp(-r);
      break;
    case WeakeningKind::kLorentzian:
      g = 1.0 / (1.0 + r * r);
      break;
    case WeakeningKind::kBoPavelescu:
      g = std::exp(-std::pow(r, exponent));
      break;
    case WeakeningKind::kHyperbolic:
      g = 1.0 / (1.0 + r);
      break;
  }
  return 1.0 - depth * (1.0 - g);
}

FrictionalLag::Relaxation FrictionalLag::relaxation(double velocity) const {
  const double level = curve.level(velocity);
  switch (kind) {
    case LagKind::kTime:
      return {1.0 / time_s, level};
    case LagKind::kDistance:
      return {std::fabs(velocity) / distance_m, level};
    case LagKind::kAttraction:
      return {attraction_per_s / level, level};
  }
  return {0.0, level};
}

}  // namespace slipstack::sim
