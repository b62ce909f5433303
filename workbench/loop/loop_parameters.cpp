// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/loop_parameters.h"

namespace slipstack::workbench {

AxisParameters supervised_axis(double encoder_resolution_m, double motor_constant_N_per_A,
                               double current_limit_A, double tick_s) {
  AxisParameters parameters;
  parameters.encoder_resolution_m = static_cast<float>(encoder_resolution_m);
  parameters.tick_s = static_cast<float>(tick_s);
  parameters.motor_constant_N_per_A = static_cast<float>(motor_constant_N_per_A);
  const auto limit_A = static_cast<float>(current_limit_A);
  parameters.current_limit_A = limit_A;
  parameters.over_current_A = 1.5F * limit_A;
  parameters.current_mismatch_A = 0.2F * limit_A;
  parameters.current_rate_A_per_s = 2000.0F * limit_A;
  parameters.stall_current_A = 0.8F * limit_A;
  parameters.stall_s = 0.1F;
  // The simulated counts keep their place.
  parameters.reference.absolute_encoder = true;
  return parameters;
}

AxisParameters loop_parameters(const sim::Axis& axis, double tick_s) {
  AxisParameters parameters =
      supervised_axis(axis.encoder_resolution_m, axis.motor_constant_N_per_A, axis.current_limit_A, tick_s);
  parameters.velocity_gain_N_s_per_m = static_cast<float>(170.0 * axis.mass_kg);
  parameters.following_error_m = 0.01F;
  return parameters;
}

ModelParameters mass_only_model(double mass_kg) {
  ModelParameters model{};
  auto& inertia = std::get<EffectParameters<Inertia<float>, float>>(model);
  inertia.enabled = true;
  inertia.gains[0] = static_cast<float>(mass_kg);
  return model;
}

}  // namespace slipstack::workbench
