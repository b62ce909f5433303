// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <tuple>

#include "firmware/control/homing/position_reference.h"
#include "firmware/control/reference/motion_limits.h"
#include "firmware/control/supervision/digital_io.h"
#include "firmware/effects/model.h"
#include "firmware/friction/packed_maxwell_slip.h"

namespace slipstack {

struct NotchParameters {
  float frequency_Hz = 0.0F;  ///< 0: off
  float damping = 0.1F;       ///< half width of the notch over its frequency
  float depth = 0.1F;         ///< gain at the centre
};

/// Everything of the axis but its friction. Fixed at start: encoder_resolution_m and tick_s.
struct AxisParameters {
  float encoder_resolution_m = 1.0e-6F;
  float tick_s = 1.0e-4F;
  float motor_constant_N_per_A = 60.0F;
  float observer_bandwidth_rad_per_s = 400.0F;
  float position_gain_per_s = 40.0F;
  float velocity_gain_N_s_per_m = 6000.0F;
  float integral_per_s = 40.0F;
  float disturbance_share = 0.0F;  ///< of the observed disturbance that is compensated, 0 to 1
  std::array<NotchParameters, 2> notch{};
  float current_limit_A = 10.0F;
  float current_rate_A_per_s = 2.0e4F;
  float velocity_limit_mps = 2.0F;
  float acceleration_limit_mps2 = 15.0F;
  float jerk_limit_mps3 = 1500.0F;
  float quick_stop_mps2 = 15.0F;
  float following_error_m = 1.0e-3F;
  float over_current_A = 15.0F;
  float current_mismatch_A = 2.0F;  ///< between set-point and measurement
  float current_mismatch_s = 2.0e-3F;
  float stall_current_A = 5.0F;  ///< this much, and the encoder stands still
  float stall_s = 0.02F;
  float unseen_motion_m = 1.0e-3F;  ///< that the current must make, and the encoder does not show; 0: off
  float stop_timeout_s = 1.0F;      ///< longest controlled stop
  float swap_time_s = 0.02F;        ///< over which a change of parameters comes into force
  bool compensate = true;           ///< false: feed-forward of the mass only
  bool adapt_level = false;
  bool adapt_mass = false;
  float level_lowest = 0.5F;
  float level_highest = 1.5F;
  float level_memory_s = 1.0F;
  float adaptation_speed_mps = 5.0e-3F;  ///< of the reference, from which on the level is adapted
  bool observe_friction = true;          ///< while the reference rests the hysteresis sees the axis
  float friction_band_counts = 0.5F;     ///< by which the axis may be elsewhere without being seen there
  float torque_friction_share = 0.0F;    ///< of the friction that is compensated in torque mode
  float hunting_swing_m = 1.0e-7F;       ///< smallest swing that is taken for hunting; 0: not watched
  float motor_rated_A = 0.0F;            ///< for ever (6075h); 0: without I2t
  float motor_thermal_s = 10.0F;         ///< time constant of the winding
  float amplifier_rated_A = 0.0F;
  float amplifier_thermal_s = 2.0F;
  bool overload_is_fault = false;    ///< else the current is limited to the rated one
  float temperature_C_per_V = 0.0F;  ///< of the analogue input; 0: none is wired
  float temperature_at_zero_C = 0.0F;
  float temperature_warning_C = 80.0F;
  float temperature_fault_C = 100.0F;
  float bus_V_per_V = 0.0F;   ///< of the DC link's input; 0: none is wired
  float bus_lowest_V = 0.0F;  ///< to drive with
  float bus_highest_V = 2.0e3F;
  bool check_direction = false;      ///< a push before operation is enabled (DirectionCheck)
  float check_distance_m = 2.0e-5F;  ///< that the push must move the axis by
  float check_current_A = 2.0F;      ///< of the push, at most
  float check_rate_A_per_s = 10.0F;
  float run_before_s = -1.0F;  ///< how long the axis had been running at the start; negative: not known
  IoParameters io;
  PositionReferenceParameters reference;
};

using ModelParameters = FrictionModel<float>::Parameters;

enum class ParameterStatus : std::uint8_t {
  kOk,
  kAxisOutOfBounds,
  kGainOutOfBounds,
  kShapeOutOfBounds,
  kNoMass,             ///< neither inertia nor payload gives the controller a mass
  kDelayTooLong,       ///< time_delay beyond what the reference can be advanced by
  kFixedAtStart,       ///< resolution or tick changed while running
  kBusy,               ///< the previous change has not been taken yet
  kEncoderTooFine,     ///< a limit of motion is more counts per tick than the reference can represent
  kEncoderTooCoarse,   ///< a limit of motion is less of a count per tick than the reference can represent
  kAmplifierTooSmall,  ///< the current limit is more than the command can ask for
};

inline constexpr std::int32_t kLargestLeadTicks = 63;

namespace detail {

struct Bound {
  float AxisParameters::*member;
  float lower;
  float upper;
};

inline constexpr auto kAxisBounds = std::to_array<Bound>({
    {&AxisParameters::encoder_resolution_m, 1.0e-10F, 1.0e-3F},
    {&AxisParameters::tick_s, 2.0e-5F, 1.0e-2F},
    {&AxisParameters::motor_constant_N_per_A, 1.0e-3F, 1.0e4F},
    {&AxisParameters::observer_bandwidth_rad_per_s, 1.0F, 2.0e4F},
    {&AxisParameters::position_gain_per_s, 0.0F, 1.0e4F},
    {&AxisParameters::velocity_gain_N_s_per_m, 0.0F, 1.0e6F},
    {&AxisParameters::integral_per_s, 0.0F, 1.0e4F},
    {&AxisParameters::disturbance_share, 0.0F, 1.0F},
    {&AxisParameters::current_limit_A, 0.0F, 1.0e3F},
    {&AxisParameters::current_rate_A_per_s, 1.0F, 1.0e8F},
    {&AxisParameters::velocity_limit_mps, 1.0e-4F, 50.0F},
    {&AxisParameters::acceleration_limit_mps2, 1.0e-3F, 1.0e3F},
    {&AxisParameters::jerk_limit_mps3, 1.0e-2F, 1.0e6F},
    {&AxisParameters::quick_stop_mps2, 1.0e-3F, 1.0e3F},
    {&AxisParameters::following_error_m, 1.0e-7F, 1.0F},
    {&AxisParameters::over_current_A, 0.0F, 1.0e3F},
    {&AxisParameters::current_mismatch_A, 1.0e-3F, 1.0e3F},
    {&AxisParameters::current_mismatch_s, 0.0F, 1.0F},
    {&AxisParameters::stall_current_A, 0.0F, 1.0e3F},
    {&AxisParameters::stall_s, 1.0e-4F, 10.0F},
    {&AxisParameters::unseen_motion_m, 0.0F, 1.0F},
    {&AxisParameters::stop_timeout_s, 1.0e-3F, 10.0F},
    {&AxisParameters::swap_time_s, 1.0e-4F, 1.0F},
    {&AxisParameters::level_lowest, 0.2F, 1.0F},
    {&AxisParameters::level_highest, 1.0F, 3.0F},
    {&AxisParameters::level_memory_s, 0.1F, 1.0e3F},
    {&AxisParameters::adaptation_speed_mps, 1.0e-4F, 10.0F},
    {&AxisParameters::friction_band_counts, 0.0F, 1.0e6F},
    {&AxisParameters::torque_friction_share, 0.0F, 1.0F},
    {&AxisParameters::hunting_swing_m, 0.0F, 1.0F},
    {&AxisParameters::motor_rated_A, 0.0F, 1.0e3F},
    {&AxisParameters::motor_thermal_s, 0.1F, 1.0e5F},
    {&AxisParameters::amplifier_rated_A, 0.0F, 1.0e3F},
    {&AxisParameters::amplifier_thermal_s, 0.1F, 1.0e5F},
    {&AxisParameters::temperature_C_per_V, -1.0e4F, 1.0e4F},
    {&AxisParameters::temperature_at_zero_C, -1.0e4F, 1.0e4F},
    {&AxisParameters::temperature_warning_C, -100.0F, 500.0F},
    {&AxisParameters::temperature_fault_C, -100.0F, 500.0F},
    {&AxisParameters::bus_V_per_V, 0.0F, 1.0e4F},
    {&AxisParameters::bus_lowest_V, 0.0F, 2.0e3F},
    {&AxisParameters::bus_highest_V, 0.0F, 2.0e3F},
    {&AxisParameters::check_distance_m, 1.0e-7F, 1.0e-3F},
    {&AxisParameters::check_current_A, 1.0e-3F, 1.0e2F},
    {&AxisParameters::check_rate_A_per_s, 1.0e-1F, 1.0e4F},
});

// False for NaN.
constexpr bool within(float value, float lower, float upper) {
  return value >= lower && value <= upper;
}

template <class E>
ParameterStatus check_effect(const EffectParameters<E, float>& own) {
  if (!own.enabled) return ParameterStatus::kOk;
  std::size_t gain = 0;
  for (const GainGroup& group : E::gains) {
    for (int i = 0; i < group.count; ++i, ++gain) {
      if (!within(own.gains[gain], group.lower, group.upper)) return ParameterStatus::kGainOutOfBounds;
    }
  }
  for (std::size_t i = 0; i < own.shapes.size(); ++i) {
    if (!within(own.shapes[i], E::shapes[i].lower, E::shapes[i].upper)) {
      return ParameterStatus::kShapeOutOfBounds;
    }
  }
  return ParameterStatus::kOk;
}

}  // namespace detail

/// The moving mass as the model has it, kg.
inline float mass_kg(const ModelParameters& model) {
  const auto& inertia = std::get<EffectParameters<Inertia<float>, float>>(model);
  const auto& payload = std::get<EffectParameters<PayloadMass<float>, float>>(model);
  return (inertia.enabled ? inertia.gains[0] : 0.0F) + (payload.enabled ? payload.gains[0] : 0.0F);
}

/// The dry friction at level 1 beyond pre-sliding, N.
inline float dry_friction_N(const ModelParameters& model) {
  const auto& hysteresis = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
  const auto& coulomb = std::get<EffectParameters<Coulomb<float>, float>>(model);
  float sum_N = coulomb.enabled ? coulomb.gains[0] : 0.0F;
  for (std::size_t i = 0; i < hysteresis.gains.size() && hysteresis.enabled; ++i)
    sum_N += hysteresis.gains[i] * hysteresis.shapes[i];
  return sum_N;
}

/// The time since the start at which the drift of the friction begins, s. Nothing tells how long the power
/// was off: an axis whose start is not known is taken for what has the least dry friction, cold where it
/// rises with time, warm for ever where it falls. A compensation that is too small leaves an error to the
/// feedback; one that is too large pushes the axis.
inline float drift_begin_s(const AxisParameters& axis, const ModelParameters& model) {
  constexpr float kForEver_s = 1.0e9F;
  if (axis.run_before_s >= 0.0F) return axis.run_before_s;
  const auto& drift = std::get<EffectParameters<Drift<float>, float>>(model);
  return drift.enabled && drift.gains[0] < 0.0F ? kForEver_s : 0.0F;
}

/// How late the force of the axis is by `time_delay`, ticks: a low pass is as late as its time constant where
/// the force changes slowly against it.
inline float delay_ticks(const ModelParameters& model, float tick_s) {
  const auto& delay = std::get<EffectParameters<TimeDelay<float>, float>>(model);
  const float lag_s = delay.shapes[0] + delay.shapes[1];
  return delay.enabled && lag_s > 0.0F ? lag_s / tick_s : 0.0F;
}

/// Whole ticks of it, by which the reference of the model runs ahead of the feedback's; the hysteresis takes
/// the rest (FeedForward::Scales::ahead).
inline std::int32_t lead_ticks(const ModelParameters& model, float tick_s) {
  return static_cast<std::int32_t>(delay_ticks(model, tick_s) + 0.5F);
}

/// The limits of the axis in counts and ticks.
inline MotionLimits motion_limits(const AxisParameters& axis) {
  const float counts_per_tick = axis.tick_s / axis.encoder_resolution_m;
  const float per_mps2 = counts_per_tick * axis.tick_s;
  return {axis.velocity_limit_mps * counts_per_tick, axis.acceleration_limit_mps2 * per_mps2,
          axis.acceleration_limit_mps2 * per_mps2, axis.jerk_limit_mps3 * per_mps2 * axis.tick_s};
}

namespace detail {

// Of moves and of stops.
inline ParameterStatus check_scale(const AxisParameters& axis) {
  const MotionLimits limits = motion_limits(axis);
  MotionLimits stop = limits;
  stop.deceleration = axis.quick_stop_mps2 * axis.tick_s * (axis.tick_s / axis.encoder_resolution_m);
  for (const MotionLimits& one : {limits, stop}) {
    const ScaleStatus status = slipstack::check_scale(one);
    if (status == ScaleStatus::kTooFast) return ParameterStatus::kEncoderTooFine;
    if (status == ScaleStatus::kTooSlow) return ParameterStatus::kEncoderTooCoarse;
  }
  return ParameterStatus::kOk;
}

}  // namespace detail

/// Whether parameters may reach the tick: every number finite and within its bounds. Outside the tick.
inline ParameterStatus check(const AxisParameters& axis, const ModelParameters& model) {
  for (const detail::Bound& bound : detail::kAxisBounds) {
    if (!detail::within(axis.*bound.member, bound.lower, bound.upper)) {
      return ParameterStatus::kAxisOutOfBounds;
    }
  }
  for (const NotchParameters& notch : axis.notch) {
    if (!detail::within(notch.frequency_Hz, 0.0F, 0.45F / axis.tick_s) ||
        !detail::within(notch.damping, 1.0e-3F, 10.0F) || !detail::within(notch.depth, 0.0F, 1.0F)) {
      return ParameterStatus::kAxisOutOfBounds;
    }
  }
  if (!(axis.bus_lowest_V < axis.bus_highest_V)) return ParameterStatus::kAxisOutOfBounds;
  if (!valid(axis.io) || !valid(axis.reference.code())) return ParameterStatus::kAxisOutOfBounds;
  ParameterStatus status = detail::check_scale(axis);
  if (status != ParameterStatus::kOk) return status;
  std::apply(
      [&status](const auto&... own) {
        const auto visit = [&status](const auto& one) {
          if (status == ParameterStatus::kOk) status = detail::check_effect(one);
        };
        (visit(own), ...);
      },
      model);
  if (status != ParameterStatus::kOk) return status;
  if (!(mass_kg(model) > 1.0e-3F)) return ParameterStatus::kNoMass;
  if (lead_ticks(model, axis.tick_s) > kLargestLeadTicks) return ParameterStatus::kDelayTooLong;
  return ParameterStatus::kOk;
}

/// Binary places of a count in which displacement reaches the hysteresis: up to 4, fewer (or negative) where
/// an encoder is so fine that its slip distances would not fit 16 bits.
inline int displacement_shift(const AxisParameters& axis, const ModelParameters& model) {
  const auto& hysteresis = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
  float largest_counts = 0.0F;
  for (const float slip_m : hysteresis.shapes) {
    largest_counts = slip_m > largest_counts ? slip_m : largest_counts;
  }
  largest_counts /= axis.encoder_resolution_m;
  constexpr auto kLargest = static_cast<float>(PackedMaxwellSlip<kTargetElements>::kLargestSlipDistance);
  int shift = 4;
  while (shift > -16 && hysteresis.enabled &&
         largest_counts * approx::power_of_two<float>(shift) > kLargest) {
    --shift;
  }
  return shift;
}

}  // namespace slipstack
