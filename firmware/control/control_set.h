// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/fault_monitor.h"
#include "firmware/control/fixed_motion.h"
#include "firmware/control/level_adaptation.h"
#include "firmware/control/notch.h"
#include "firmware/control/parameters.h"
#include "firmware/control/state_estimate.h"
#include "firmware/effects/model_hash.h"

namespace slipstack {

/// Parameters as the tick wants them: checked, multiplied out, the model prepared.
struct ControlSet {
  AxisParameters axis;
  std::uint32_t hash = 0;
  std::int32_t lead = 0;
  int displacement_shift = 0;
  std::int32_t shift_up = 0;
  std::int32_t shift_down = 0;
  float steps_per_count = 1.0F;
  float mass_kg = 1.0F;
  float per_mass_kg = 1.0F;
  float mps_per_count = 0.0F;
  float mps2_per_count = 0.0F;
  float A_per_N = 0.0F;
  float integral_per_tick = 0.0F;
  float blend_keep = 0.0F;
  float disturbance_kg = 0.0F;
  float adaptation_counts = 0.0F;
  float largest_step_A = 0.0F;
  std::int32_t stop_timeout_ticks = 0;
  std::int64_t braking = 0;
  StateEstimate::Gains estimate;
  std::array<Notch::Gains, 2> notch;
  FaultMonitor::Bounds monitor;
  LevelAdaptation::Bounds adaptation;
  bool valid = false;
  FrictionModel<float> model;  // last: large

  /// Outside the tick: some 200 000 instructions, most of them for tables. Nothing changes unless kOk.
  ParameterStatus prepare(const AxisParameters& new_axis, const ModelParameters& parameters) {
    const ParameterStatus status = check(new_axis, parameters);
    if (status != ParameterStatus::kOk) return status;
    axis = new_axis;
    hash = model_hash(parameters);
    lead = lead_ticks(parameters, axis.tick_s);
    displacement_shift = slipstack::displacement_shift(axis, parameters);
    shift_up = displacement_shift > 0 ? displacement_shift : 0;
    shift_down = displacement_shift < 0 ? -displacement_shift : 0;
    steps_per_count = displacement_shift > 0 ? approx::power_of_two<float>(displacement_shift) : 0.0F;
    mass_kg = slipstack::mass_kg(parameters);
    per_mass_kg = 1.0F / mass_kg;
    mps_per_count = axis.encoder_resolution_m / axis.tick_s;
    mps2_per_count = mps_per_count / axis.tick_s;
    A_per_N = 1.0F / axis.motor_constant_N_per_A;
    integral_per_tick = axis.integral_per_s * axis.tick_s;
    blend_keep = approx::exp(-3.0F * axis.tick_s / axis.swap_time_s);
    disturbance_kg = axis.disturbance_share * mass_kg;
    // Beyond any velocity when it is switched off.
    adaptation_counts = axis.adapt_level ? axis.adaptation_speed_mps / mps_per_count : 1.0e30F;
    largest_step_A = axis.current_rate_A_per_s * axis.tick_s;
    stop_timeout_ticks = static_cast<std::int32_t>(axis.stop_timeout_s / axis.tick_s);
    braking = to_fixed(axis.quick_stop_mps2 / mps2_per_count) + 1;
    estimate =
        StateEstimate::gains(axis.encoder_resolution_m, axis.tick_s, axis.observer_bandwidth_rad_per_s);
    for (std::size_t i = 0; i < notch.size(); ++i) {
      const NotchParameters& own = axis.notch[i];
      notch[i] = Notch::gains(own.frequency_Hz, own.damping, own.depth, axis.tick_s);
    }
    monitor = FaultMonitor::bounds(axis);
    adaptation =
        LevelAdaptation::bounds(axis.level_lowest, axis.level_highest, axis.level_memory_s, axis.tick_s);
    const Scales<float> scales{axis.tick_s,
                               axis.encoder_resolution_m * approx::power_of_two<float>(-displacement_shift)};
    model.prepare(axis.compensate ? parameters : mass_only(parameters), scales);
    valid = true;
    return ParameterStatus::kOk;
  }

  /// Takes over the state of the model that runs; hysteresis only if displacement has the same unit.
  void continue_from(const ControlSet& other) {
    if (other.valid && other.displacement_shift == displacement_shift) model.carry_over(other.model);
  }

 private:
  static ModelParameters mass_only(const ModelParameters& parameters) {
    ModelParameters kept{};
    std::get<EffectParameters<Inertia<float>, float>>(kept) =
        std::get<EffectParameters<Inertia<float>, float>>(parameters);
    std::get<EffectParameters<PayloadMass<float>, float>>(kept) =
        std::get<EffectParameters<PayloadMass<float>, float>>(parameters);
    return kept;
  }
};

}  // namespace slipstack
