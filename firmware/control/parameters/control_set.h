// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/bounds/motion_bounds.h"
#include "firmware/control/exchange_box.h"
#include "firmware/control/force/adaptation.h"
#include "firmware/control/force/feedback.h"
#include "firmware/control/force/feedforward.h"
#include "firmware/control/force/hysteresis_memory.h"
#include "firmware/control/force/state_estimate.h"
#include "firmware/control/hunting/hunting_watch.h"
#include "firmware/control/parameters/parameters.h"
#include "firmware/control/supervision/digital_io.h"
#include "firmware/control/supervision/direction_check.h"
#include "firmware/control/supervision/fault_monitor.h"
#include "firmware/control/supervision/unseen_motion.h"
#include "firmware/effects/model_hash.h"

namespace slipstack {

/// Parameters in the form that the tick uses: checked, multiplied out, the model prepared.
struct ControlSet {
  std::int32_t lead = 0;
  int displacement_shift = 0;
  float mass_kg = 1.0F;
  float per_mass_kg = 1.0F;
  float mps_per_count = 0.0F;
  float mps2_per_count = 0.0F;
  float A_per_N = 0.0F;
  float counts_per_mps = 0.0F;
  float blend_keep = 0.0F;
  float disturbance_kg = 0.0F;
  float uncompensated_share = 1.0F;  ///< of a disturbance: the integral's
  float adaptation_counts = 0.0F;
  float torque_share = 0.0F;  ///< of the friction that is compensated in torque mode
  float largest_step_A = 0.0F;
  float drift_begin_s = 0.0F;  ///< for the main loop
  StateEstimate::Gains estimate;
  FeedForward::Scales scales;
  Feedback::Gains feedback;
  FaultMonitor::Bounds monitor;
  UnseenMotion::Settings unseen;
  IoMasks io;
  float inertia_kg = 0.0F;  ///< as the model has it, for the main loop
  ExchangeBox<MotionBounds> bounds;
  AxisParameters axis;
  std::uint32_t hash = 0;
  bool valid = false;
  FrictionModel<float> model;
  TargetCurve virgin_curve;       ///< for the main loop
  std::int32_t start_counts = 0;  ///< where the axis is before there are parameters
  std::uint32_t number = 0;       ///< of this set, counted since the start
  DirectionCheck::Settings direction;
  Adaptation::Bounds adaptation;  ///< for the main loop, as the next one
  HuntingWatch::Settings hunting;

  /// Outside the tick. Nothing changes unless kOk.
  ParameterStatus prepare(const AxisParameters& new_axis, const ModelParameters& parameters,
                          const UserBounds& user) {
    const ParameterStatus status = check(new_axis, parameters);
    if (status != ParameterStatus::kOk) return status;
    axis = new_axis;
    hash = model_hash(parameters);
    lead = lead_ticks(parameters, axis.tick_s);
    // In the middle of the tick over which the force is held.
    scales.ahead = 0.5F + delay_ticks(parameters, axis.tick_s) - static_cast<float>(lead);
    displacement_shift = slipstack::displacement_shift(axis, parameters);
    mass_kg = slipstack::mass_kg(parameters);
    per_mass_kg = 1.0F / mass_kg;
    mps_per_count = axis.encoder_resolution_m / axis.tick_s;
    mps2_per_count = mps_per_count / axis.tick_s;
    counts_per_mps = 1.0F / mps_per_count;
    A_per_N = 1.0F / axis.motor_constant_N_per_A;
    blend_keep = approx::exp(-3.0F * axis.tick_s / axis.swap_time_s);
    compensate_disturbance(1.0F);
    torque_share = axis.torque_friction_share;
    // Beyond any velocity when it is switched off.
    adaptation_counts =
        axis.adapt_level || axis.adapt_mass ? axis.adaptation_speed_mps / mps_per_count : 1.0e30F;
    largest_step_A = axis.current_rate_A_per_s * axis.tick_s;
    drift_begin_s = slipstack::drift_begin_s(axis, parameters);
    bounds.write(MotionBounds::of(axis, user));
    estimate =
        StateEstimate::gains(axis.encoder_resolution_m, axis.tick_s, axis.observer_bandwidth_rad_per_s);
    prepare_feedback();
    monitor = FaultMonitor::bounds(axis);
    unseen = UnseenMotion::settings(axis, parameters);
    prepare_check();
    io = IoMasks::of(axis.io);
    Adaptation::set(adaptation, axis, dry_friction_N(parameters), mass_kg);
    hunting = HuntingWatch::settings(axis, parameters);
    prepare_model(axis.compensate ? parameters : mass_only(parameters));
    valid = true;
    return ParameterStatus::kOk;
  }

  /// Outside the tick: from the next tick on motion is bounded by this, too.
  void bound(const UserBounds& user) {
    if (valid) bounds.write(MotionBounds::of(axis, user));
  }

  /// The model starts anew, with unloaded hysteresis, at this position.
  void forget_motion(std::int32_t counts) {
    Sample<float> here;
    here.displacement = FeedForward::displacement(scales, {.counts = counts});
    model.reset(here);
  }

  /// Outside the tick: the feed-forward of the mass with so much more.
  void add_mass(float added_kg) { model.set_gain<Inertia<float>>(0, inertia_kg + added_kg); }

  /// Outside the tick: this part of the share of the disturbance that is to be compensated.
  void compensate_disturbance(float part) {
    disturbance_kg = part * axis.disturbance_share * mass_kg;
    uncompensated_share = 1.0F - part * axis.disturbance_share;
  }

  /// Takes over the state of the model that runs; hysteresis only if displacement has the same unit. The
  /// first parameters find an axis at rest, its hysteresis unloaded.
  void continue_from(const ControlSet& other) {
    if (!valid) return;
    if (!other.valid) {
      forget_motion(other.start_counts);
    } else if (other.displacement_shift == displacement_shift) {
      model.carry_over(other.model);
    }
  }

 private:
  void prepare_feedback() {
    feedback.resolution_m = axis.encoder_resolution_m;
    feedback.mps_per_count = mps_per_count;
    feedback.position_per_s = axis.position_gain_per_s;
    feedback.velocity_N_s_per_m = axis.velocity_gain_N_s_per_m;
    feedback.integral_per_tick = axis.integral_per_s * axis.tick_s;
    for (std::size_t i = 0; i < feedback.notch.size(); ++i) {
      const NotchParameters& own = axis.notch[i];
      feedback.notch[i] = Notch::gains(own.frequency_Hz, own.damping, own.depth, axis.tick_s);
    }
  }

  void prepare_check() {
    // Fewer counts than four could be noise.
    constexpr float kFewest = 4.0F;
    const float counts = axis.check_distance_m / axis.encoder_resolution_m;
    direction.wanted = axis.check_direction;
    // At a distance of 20 um: 1 mm/s.
    constexpr float kStand_s = 0.02F;
    direction.stand_ticks = static_cast<std::int32_t>(kStand_s / axis.tick_s) + 1;
    direction.distance_counts = static_cast<std::int32_t>(approx::clamp(counts, kFewest, 1.0e8F));
    direction.largest_N = axis.check_current_A * axis.motor_constant_N_per_A;
    direction.step_N = axis.check_rate_A_per_s * axis.motor_constant_N_per_A * axis.tick_s;
    // As long again as the last quarter of the rise.
    direction.hold_ticks = static_cast<std::int32_t>(0.25F * direction.largest_N / direction.step_N);
  }

  void prepare_model(const ModelParameters& parameters) {
    scales.resolution_m = axis.encoder_resolution_m;
    scales.mps_per_count = mps_per_count;
    scales.mps2_per_count = mps2_per_count;
    scales.shift_up = displacement_shift > 0 ? displacement_shift : 0;
    scales.shift_down = displacement_shift < 0 ? -displacement_shift : 0;
    scales.steps_per_count = approx::power_of_two<float>(displacement_shift);
    scales.steps_per_m = scales.steps_per_count / axis.encoder_resolution_m;
    prepare_observer();
    const float metres_per_step =
        axis.encoder_resolution_m * approx::power_of_two<float>(-displacement_shift);
    const auto& inertia = std::get<EffectParameters<Inertia<float>, float>>(parameters);
    inertia_kg = inertia.enabled ? inertia.gains[0] : 0.0F;
    model.prepare(parameters, Scales<float>{axis.tick_s, metres_per_step});
    virgin_curve = virgin_curve_of(parameters, metres_per_step);
  }

  void prepare_observer() {
    const float steps = axis.friction_band_counts * approx::power_of_two<float>(displacement_shift);
    // Sums of two stay in 32 bits.
    constexpr float kMost = 1.0e9F;
    scales.band = static_cast<std::int32_t>(approx::clamp(steps + 0.5F, 0.0F, kMost));
    // What the observer takes from an integral that does not integrate would stay there. A stream that stands
    // leaves the rounding of its path.
    constexpr float kRest = 0x1p-10F;
    scales.rest = axis.observe_friction && axis.integral_per_s > 0.0F ? kRest : 0.0F;
  }

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
