// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>

#include "firmware/control/control_set.h"
#include "firmware/control/current_limit.h"
#include "firmware/control/fault_monitor.h"
#include "firmware/control/level_adaptation.h"
#include "firmware/control/motion_plan.h"
#include "firmware/control/notch.h"
#include "firmware/control/parameter_swap.h"
#include "firmware/control/reference.h"
#include "firmware/control/state_estimate.h"
#include "firmware/control/state_machine.h"

namespace slipstack {

/// What the controller tells after each tick.
struct ControlOutput {
  float current_A = 0.0F;
  bool driving = false;      ///< false: power stage off
  std::uint16_t limits = 0;  ///< bits of Limit
  std::int32_t reference_counts = 0;
  float position_error_m = 0.0F;  ///< reference less estimate
  float velocity_mps = 0.0F;      ///< estimated
  float feedforward_N = 0.0F;     ///< model on the reference, level included
  float feedback_N = 0.0F;
  float residual_N = 0.0F;  ///< force that the model misses, from the disturbance observer
  float level = 1.0F;       ///< adapted friction level
};

/// One axis: from encoder counts to a current, every tick the same work.
///
///   F = model(reference) + level change + notch(Kv (v_ref + Kp e - v) + integral) - share x disturbance
///
/// The model sees the reference, never the measurement: it is a feed-forward, and whatever it or its
/// adaptation does, the loop that could become unstable is that of the linear feedback (docs/control.md).
class Controller {
 public:
  /// Outside the tick: checks and prepares new parameters; the next tick takes them, or a later one (call
  /// poll() from the main loop). Refused parameters change nothing, and stop an enabled axis.
  ParameterStatus configure(const AxisParameters& axis, const ModelParameters& model) {
    ControlSet* spare = sets_.spare();
    if (spare == nullptr) return ParameterStatus::kBusy;
    const AxisParameters& now = sets_.active().axis;
    const bool changed = axis.encoder_resolution_m != now.encoder_resolution_m || axis.tick_s != now.tick_s;
    if (sets_.active().valid && changed) return ParameterStatus::kFixedAtStart;
    const ParameterStatus status = spare->prepare(axis, model);
    if (status == ParameterStatus::kOk) {
      sets_.arm();
    } else {
      events_.fetch_or(kRefused, std::memory_order_release);
    }
    return status;
  }
  void poll() {
    if (sets_.pending()) sets_.arm();
  }
  bool change_pending() const { return sets_.pending(); }

  /// Outside the tick: the control word 6040h.
  void command(std::uint16_t control_word) { control_word_.store(control_word, std::memory_order_release); }
  /// Outside the tick: queues a move from rest, within the limits of the axis.
  PlanStatus move_to(std::int32_t counts) {
    const ControlSet& set = sets_.active();
    const float per_mps = 1.0F / set.mps_per_count;
    const float per_mps2 = 1.0F / set.mps2_per_count;
    return plan_move(reference_, counts,
                     {set.axis.velocity_limit_mps * per_mps, set.axis.acceleration_limit_mps2 * per_mps2,
                      set.axis.jerk_limit_mps3 * per_mps2 * set.axis.tick_s});
  }
  ReferenceGenerator& reference() { return reference_; }
  const ReferenceGenerator& reference() const { return reference_; }
  /// Outside the tick: a fault found elsewhere, as a reset by the watchdog; seen by the next tick.
  void inject(Fault fault) { events_.store(static_cast<std::uint32_t>(fault), std::memory_order_release); }

  /// In the tick.
  const ControlOutput& step(const TickInputs& in) {
    out_.limits = 0;
    const bool swapped = sets_.begin_tick();
    if (swapped) take_parameters(in.encoder.counts);
    ControlSet& set = *approx::one_address(&sets_.active());
    supervise(in, set);
    if (!out_.driving) rest(in.encoder.counts);
    estimate_.step(set.estimate, in.encoder.counts, expected_mps2_);

    const std::uint32_t tick = sets_.tick();
    ReferencePoint& ahead = delay_[tick % kDelayed];
    reference_.next(ahead, set.braking);
    const float model_N = model_force(set, ahead, tick);
    const ReferencePoint& now = delayed(tick, set.lead);
    const float feedback_N = feedback(set, now);
    const float disturbance_mps2 = estimate_.disturbance_mps2();
    float wanted_N = model_N + feedback_N - set.disturbance_kg * disturbance_mps2;
    if (swapped) blend_N_ = out_.driving ? last_wanted_N_ - wanted_N : 0.0F;
    wanted_N += blend_N_;
    blend_N_ *= set.blend_keep;
    last_wanted_N_ = wanted_N;

    const float force_N = drive(set, wanted_N);
    expected_mps2_ = now.acceleration * set.mps2_per_count + (force_N - model_N) * set.per_mass_kg;
    integral_N_ += set.integral_per_tick * (proportional_N_ + force_N - wanted_N);
    adapt(set, now, disturbance_mps2);
    return out_;
  }

  const ControlOutput& output() const { return out_; }
  const FrictionModel<float>::Force& friction() const { return sets_.active().model.force(); }
  const StateMachine& state() const { return state_; }
  const StateEstimate& estimate() const { return estimate_; }
  /// As the encoder said at the last tick.
  std::int32_t measured_counts() const { return monitor_.last_counts(); }
  const ControlSet& parameters() const { return sets_.active(); }
  std::uint32_t ticks() const { return sets_.tick(); }

 private:
  static constexpr std::uint32_t kRefused = 0x100;
  static constexpr std::uint32_t kDelayed = 64;
  static_assert(kLargestLeadTicks < static_cast<std::int32_t>(kDelayed));

  void take_parameters(std::int32_t counts) {
    adaptation_.limit(sets_.active().adaptation);
    if (started_) return;
    started_ = true;
    estimate_.reset(counts);
    monitor_.reset(counts);
  }

  void supervise(const TickInputs& in, const ControlSet& set) {
    Fault fault = set.valid
                      ? monitor_.check(set.monitor, in, out_.reference_counts, limit_.last_A(), out_.driving)
                      : Fault::kNone;
    if (events_.load(std::memory_order_relaxed) != 0) fault = take_event(fault);
    const std::uint16_t control = control_word_.load(std::memory_order_relaxed);
    if (state_.goes_on(control, fault)) return;
    state_.step(control, fault, set.valid, reference_.standing(), set.stop_timeout_ticks);
    out_.driving = state_.driving();
    if (state_.braking() && !reference_.braking() && !reference_.standing()) reference_.stop();
  }

  // What came from outside the tick: an injected fault, or parameters that were refused.
  Fault take_event(Fault fault) {
    const std::uint32_t event = events_.exchange(0, std::memory_order_acquire);
    const auto injected = static_cast<Fault>(event & 0xFFU);
    if (injected != Fault::kNone) return injected;
    return out_.driving && fault == Fault::kNone ? Fault::kParameter : fault;
  }

  // Without current the reference lies where the axis is, so that the hysteresis follows it.
  void rest(std::int32_t counts) {
    reference_.hold(counts);
    integral_N_ = 0.0F;
    expected_mps2_ = 0.0F;
    limit_.reset();
    for (Notch& notch : notch_) notch.reset();
  }

  float model_force(ControlSet& set, const ReferencePoint& at, std::uint32_t tick) {
    const AxisParameters& axis = set.axis;
    const Sample<float> sample{
        .time_s = static_cast<float>(tick) * axis.tick_s,
        // Counts times 2^up / 2^down; one of the two is zero.
        .displacement = (static_cast<std::int32_t>(static_cast<std::uint32_t>(at.counts) << set.shift_up) >>
                         set.shift_down) +
                        static_cast<std::int32_t>(at.fraction * set.steps_per_count),
        .position_m = (static_cast<float>(at.counts) + at.fraction) * axis.encoder_resolution_m,
        .velocity_mps = at.velocity * set.mps_per_count,
        .acceleration_mps2 = at.acceleration * set.mps2_per_count,
        .dry_friction_N = 0.0F};
    const FrictionModel<float>::Force& force = set.model.step(sample);
    dry_N_ = force.dry_friction_N;
    out_.feedforward_N = force.total_N + (adaptation_.level() - 1.0F) * dry_N_;
    return out_.feedforward_N;
  }

  const ReferencePoint& delayed(std::uint32_t tick, std::int32_t ticks) const {
    // Before the axis was enabled there is no history worth waiting for.
    return delay_[(tick - (out_.driving ? static_cast<std::uint32_t>(ticks) : 0U)) % kDelayed];
  }

  float feedback(const ControlSet& set, const ReferencePoint& at) {
    const AxisParameters& axis = set.axis;
    const float error_m = (static_cast<float>(difference(at.counts, estimate_.counts())) + at.fraction) *
                              axis.encoder_resolution_m -
                          estimate_.offset_m();
    const float wanted_mps = at.velocity * set.mps_per_count + axis.position_gain_per_s * error_m;
    proportional_N_ = axis.velocity_gain_N_s_per_m * (wanted_mps - estimate_.velocity_mps());
    out_.reference_counts = at.counts;
    out_.position_error_m = error_m;
    out_.velocity_mps = estimate_.velocity_mps();
    out_.feedback_N =
        notch_[1].step(set.notch[1], notch_[0].step(set.notch[0], proportional_N_ + integral_N_));
    return out_.feedback_N;
  }

  /// The force that the limited current gives.
  float drive(const ControlSet& set, float wanted_N) {
    const float wanted_A = wanted_N * set.A_per_N;
    // All bits of the exponent set: infinite, or not a number.
    const bool finite = (std::bit_cast<std::uint32_t>(wanted_A) & 0x7F800000U) != 0x7F800000U;
    if (!finite && out_.driving) {
      state_.raise(Fault::kNotFinite);
      out_.driving = false;
    }
    if (!out_.driving) {
      limit_.reset();
      if (!finite) clear();
      out_.current_A = 0.0F;
      return wanted_N;
    }
    out_.current_A = limit_.step(set.axis.current_limit_A, set.largest_step_A, wanted_A, out_.limits);
    if (reference_.braking()) out_.limits |= kLimitReference;
    return out_.current_A * set.axis.motor_constant_N_per_A;
  }

  // What a value that is not a number may have reached.
  void clear() {
    integral_N_ = blend_N_ = last_wanted_N_ = expected_mps2_ = proportional_N_ = 0.0F;
    for (Notch& notch : notch_) notch.reset();
    estimate_.reset(estimate_.counts());
  }

  // In every other tick; new parameters come into force in those between, so that no tick has both.
  void adapt(const ControlSet& set, const ReferencePoint& at, float disturbance_mps2) {
    out_.residual_N = -set.mass_kg * disturbance_mps2;
    out_.level = adaptation_.level();
    if (!LevelAdaptation::takes_part(sets_.tick()) || out_.limits != 0 || !out_.driving) return;
    if (approx::absolute(at.velocity) <= set.adaptation_counts) return;
    adaptation_.step(set.adaptation, dry_N_, out_.residual_N);
  }

  StateMachine state_;
  FaultMonitor monitor_;
  ReferenceGenerator reference_;
  StateEstimate estimate_;
  std::array<Notch, 2> notch_;
  CurrentLimit limit_;
  LevelAdaptation adaptation_;
  ControlOutput out_;
  float integral_N_ = 0.0F;
  float proportional_N_ = 0.0F;
  float blend_N_ = 0.0F;
  float last_wanted_N_ = 0.0F;
  float expected_mps2_ = 0.0F;
  float dry_N_ = 0.0F;
  bool started_ = false;
  std::atomic<std::uint16_t> control_word_{0};
  std::atomic<std::uint32_t> events_{0};  // a fault, and kRefused
  // Last, because they are large: what comes before is near one base address.
  std::array<ReferencePoint, kDelayed> delay_{};
  ParameterSwap<ControlSet> sets_;
};

}  // namespace slipstack
