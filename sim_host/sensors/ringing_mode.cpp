// SPDX-License-Identifier: Apache-2.0
#include "sim_host/sensors/ringing_mode.h"

#include <cmath>
#include <stdexcept>

#include "sim_host/turn.h"

namespace slipstack::sim {

RingingMode::RingingMode(double step_s, double frequency_Hz, double damping_ratio) : step_s_(step_s) {
  if (!(step_s > 0.0) || !(frequency_Hz > 0.0) || !(damping_ratio >= 0.0 && damping_ratio < 1.0)) {
    throw std::invalid_argument("ringing mode: step and frequency must be positive, damping below 1");
  }
  const double rate_per_s = kTurn * frequency_Hz;
  const double damped_per_s = rate_per_s * std::sqrt(1.0 - damping_ratio * damping_ratio);
  const double decay_per_s = damping_ratio * rate_per_s;
  const double left = std::exp(-decay_per_s * step_s);
  const double cosine = left * std::cos(damped_per_s * step_s);
  const double sine = left * std::sin(damped_per_s * step_s);
  lag_s_ = 2.0 * damping_ratio / rate_per_s;
  value_by_value_ = cosine + decay_per_s / damped_per_s * sine;
  value_by_rate_s_ = sine / damped_per_s;
  rate_by_value_per_s_ = -rate_per_s * rate_per_s / damped_per_s * sine;
  rate_by_rate_ = cosine - decay_per_s / damped_per_s * sine;
}

double RingingMode::push(double force_N) {
  if (!started_) {
    started_ = true;
    force_N_ = reading_N_ = force_N;
    return 0.0;
  }
  // About a ramp, which the reading follows 2ζ/ω late, it moves freely.
  const double slope_N_per_s = (force_N - force_N_) / step_s_;
  const double value_N = reading_N_ - (force_N_ - lag_s_ * slope_N_per_s);
  const double rate_N_per_s = rate_N_per_s_ - slope_N_per_s;
  reading_N_ = force_N - lag_s_ * slope_N_per_s + value_by_value_ * value_N + value_by_rate_s_ * rate_N_per_s;
  rate_N_per_s_ = slope_N_per_s + rate_by_value_per_s_ * value_N + rate_by_rate_ * rate_N_per_s;
  force_N_ = force_N;
  return reading_N_ - force_N;
}

}  // namespace slipstack::sim
