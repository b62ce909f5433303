// SPDX-License-Identifier: Apache-2.0
// The parameters of one linear axis.
#pragma once

#include <cstddef>

#include "sim_host/plant/effects/effects.h"
#include "sim_host/plant/friction/virgin_curve.h"

namespace slipstack::sim {

struct Axis {
  double mass_kg = 10.0;  // moving mass with the arm, without payload
  VirginCurve curve;
  std::size_t elements = 200;
  double stroke_m = 0.3;  // the axis moves on 0 … stroke
  double magnet_pitch_m = 0.024;
  double motor_constant_N_per_A = 40.0;
  double current_limit_A = 20.0;
  double current_loop_rad_per_s = 0.0;  // 0: the current follows its command without delay
  double encoder_resolution_m = 1e-7;
  double force_noise_N = 0.0;  // white, standard deviation per sample
  Effects effects;
  Outside outside;
};

}  // namespace slipstack::sim
