// SPDX-License-Identifier: Apache-2.0
#include "sim_host/control/cascade.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipstack::sim {

CascadeController::CascadeController(const Gains& gains, double period_s, double position_m)
    : gains_(gains),
      period_s_(period_s),
      filter_(-std::expm1(-gains.velocity_filter_rad_per_s * period_s)),
      last_m_(position_m) {}

CascadeController::Gains CascadeController::tuned(const Axis& axis, double bandwidth_Hz) {
  double w = 2.0 * std::numbers::pi * bandwidth_Hz;
  if (axis.encoder_resolution_m > 0.0) {
    // One count jumps the filtered velocity by resolution × 4w, and the force by mass × w times that.
    const double loudest_N = axis.curve.saturation_N() / 3.0;
    w = std::min(w, std::sqrt(loudest_N / (4.0 * axis.mass_kg * axis.encoder_resolution_m)));
  }
  Gains gains;
  gains.position_per_s = 0.25 * w;
  gains.velocity_N_s_per_m = axis.mass_kg * w;
  gains.integral_per_s = 0.25 * w;
  gains.velocity_filter_rad_per_s = 4.0 * w;
  gains.feedforward_kg = axis.mass_kg;
  gains.limit_N = axis.current_limit_A * axis.motor_constant_N_per_A;
  return gains;
}

double CascadeController::update_N(const MotionPoint& reference, double measured_m) {
  velocity_mps_ += filter_ * ((measured_m - last_m_) / period_s_ - velocity_mps_);
  last_m_ = measured_m;
  const double wanted_mps = reference.v_mps + gains_.position_per_s * (reference.x_m - measured_m);
  const double proportional_N = gains_.velocity_N_s_per_m * (wanted_mps - velocity_mps_);
  const double wanted_N = gains_.feedforward_kg * reference.a_mps2 + proportional_N + integral_N_;
  const double force_N = std::clamp(wanted_N, -gains_.limit_N, gains_.limit_N);
  const bool winding = wanted_N != force_N && (wanted_N > 0.0) == (proportional_N > 0.0);
  if (!winding) integral_N_ += gains_.integral_per_s * period_s_ * proportional_N;
  return force_N;
}

}  // namespace slipstack::sim
