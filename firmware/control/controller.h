// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>

#include "firmware/control/control_set.h"
#include "firmware/control/current_limit.h"
#include "firmware/control/fault_monitor.h"
#include "firmware/control/feedback.h"
#include "firmware/control/feedforward.h"
#include "firmware/control/hysteresis_memory.h"
#include "firmware/control/level_adaptation.h"
#include "firmware/control/motion_plan.h"
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
  float feedforward_N = 0.0F;     ///< model on the reference, level included; in torque mode not applied
  float feedback_N = 0.0F;
  float residual_N = 0.0F;  ///< force that the model misses, from the disturbance observer
  float level = 1.0F;       ///< adapted friction level
};

/// One axis: from encoder counts to a current, every tick the same work.
///
///   F = model(reference) + level change + notch(Kv (v_ref + Kp e - v) + integral) - share x disturbance
///       + offset
///
/// The model sees the reference, never the measurement: it is a feed-forward, and whatever it or its
/// adaptation does, the loop that could become unstable is that of the linear feedback (docs/control.md).
///
/// In torque mode F = target + offset. The reference then follows the axis, and with it the hysteresis; a
/// stop begins at the axis's own velocity. The change from one to the other fades as one of parameters does.
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
      spare->number = sets_.active().number + 1;
      sets_.arm();
    } else {
      events_.fetch_or(kRefused, std::memory_order_release);
    }
    return status;
  }
  /// From the main loop, at least every kLatest ticks: a change of parameters that a tick has missed, and the
  /// memory of the hysteresis (200 instructions for each tick since the last call).
  void poll() {
    if (sets_.pending()) sets_.arm();
    remember();
  }
  bool change_pending() const { return sets_.pending(); }

  /// Outside the tick: the control word 6040h.
  void command(std::uint16_t control_word) {
    command_all((command_.load(std::memory_order_relaxed) & 0xFFFF0000U) | control_word);
  }
  /// Outside the tick: the same with kTorqueMode and kReleaseOnFault.
  void command_all(std::uint32_t command) { command_.store(command, std::memory_order_release); }
  /// Outside the tick: the force in torque mode, and the force that is added in every mode, N.
  void set_torque(float target_N, float offset_N) {
    target_N_.store(target_N, std::memory_order_relaxed);
    offset_N_.store(offset_N, std::memory_order_relaxed);
  }
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
    ControlSet* active = approx::one_address(&sets_.active());
    supervise(in, *active);
    if (sets_.begin_tick(!busy())) [[unlikely]] {
      active = approx::one_address(&sets_.active());
      take_parameters(*active, in.encoder.counts);
    }
    ControlSet& set = *active;
    if (following_) follow(set, in.encoder.counts);
    estimate_.step(set.estimate, in.encoder.counts, expected_mps2_);

    const std::uint32_t tick = sets_.tick();
    ReferencePoint& ahead = delay_[tick % kDelayed];
    reference_.next(ahead, set.braking);
    const float model_N = feedforward_.step(set.model, set.scales, ahead, tick, adaptation_.level());
    const ReferencePoint& now = delay_[(tick - lead_) % kDelayed];
    const float feedback_N = feedback_.step(set.feedback, now, estimate_, out_.position_error_m);
    tell(now, model_N, feedback_N);
    const float disturbance_mps2 = estimate_.disturbance_mps2();
    float wanted_N = approx::multiply_subtract(set.disturbance_kg, disturbance_mps2, model_N + feedback_N);
    if (torque_) wanted_N = give_torque(now);
    wanted_N += offset_N_.load(std::memory_order_relaxed);
    if (fades_) [[unlikely]]
      begin_fading(wanted_N);
    wanted_N += blend_N_;
    blend_N_ *= set.blend_keep;
    last_wanted_N_ = wanted_N;

    const float force_N = drive(set, wanted_N);
    expected_mps2_ =
        approx::multiply_add(force_N - model_N, set.per_mass_kg, now.acceleration * set.mps2_per_count);
    feedback_.integrate(set.feedback, force_N, wanted_N);
    adapt(set, now, disturbance_mps2);
    return out_;
  }

  const ControlOutput& output() const { return out_; }
  const FrictionModel<float>::Force& friction() const { return sets_.active().model.force(); }
  /// As far as the last poll() has followed the tick.
  const HysteresisMemory& memory() const { return memory_; }
  const StateMachine& state() const { return state_; }
  const StateEstimate& estimate() const { return estimate_; }
  /// As the sensors said at the last tick.
  std::int32_t measured_counts() const { return monitor_.last_counts(); }
  float measured_A() const { return monitor_.last_A(); }
  const ControlSet& parameters() const { return sets_.active(); }
  std::uint32_t ticks() const { return sets_.tick(); }

 private:
  static constexpr std::uint32_t kRefused = 0x100;
  static constexpr std::uint32_t kDelayed = 64;
  static_assert(kLargestLeadTicks < static_cast<std::int32_t>(kDelayed));

 public:
  /// How many ticks poll() may be late without missing one.
  static constexpr std::uint32_t kLatest = kDelayed - 8;

 private:
  void take_parameters(const ControlSet& set, std::int32_t counts) {
    adaptation_.limit(set.adaptation);
    postpone_adaptation();
    fades_ = true;
    set_lead(set);
    if (started_) return;
    started_ = true;
    estimate_.reset(counts);
    monitor_.reset(counts);
  }

  void supervise(const TickInputs& in, ControlSet& set) {
    Fault fault = Fault::kNone;
    if (set.valid) [[likely]] {
      fault = monitor_.check(set.monitor, in, out_.reference_counts, limit_.last_A(), out_.driving);
    } else {
      set.start_counts = in.encoder.counts;
    }
    if (events_.load(std::memory_order_relaxed) != 0) fault = take_event(fault);
    const std::uint32_t command = command_.load(std::memory_order_relaxed);
    if (state_.goes_on(command, fault)) return;
    state_.step(command, fault, set.valid, reference_.standing(), set.stop_timeout_ticks);
    const bool driving = state_.driving();
    const bool torque = state_.torque_mode();
    const bool changed = torque != torque_;
    fades_ |= changed && driving && out_.driving;
    set_mode(set, torque, driving);
    if (driving) postpone_adaptation();
    const bool brake = state_.braking() || (changed && !torque);
    if (brake && !reference_.braking() && !reference_.standing()) reference_.stop();
  }

  void set_mode(const ControlSet& set, bool torque, bool driving) {
    torque_ = torque;
    out_.driving = driving;
    following_ = torque || !driving;
    set_lead(set);
  }

  // Before the axis follows its reference there is no history worth waiting for.
  void set_lead(const ControlSet& set) {
    lead_ = following_ ? std::uint8_t{0} : static_cast<std::uint8_t>(set.lead);
  }

  void begin_fading(float wanted_N) {
    blend_N_ = out_.driving ? last_wanted_N_ - wanted_N : 0.0F;
    // Out of torque mode the force that brakes comes a tick or two later: it shall fade in as well.
    fades_ = reference_.about_to_brake();
  }

  // What came from outside the tick: an injected fault, or parameters that were refused.
  Fault take_event(Fault fault) {
    const std::uint32_t event = events_.exchange(0, std::memory_order_acquire);
    const auto injected = static_cast<Fault>(event & 0xFFU);
    if (injected != Fault::kNone) return injected;
    return out_.driving && fault == Fault::kNone ? Fault::kParameter : fault;
  }

  // Without current, and in torque mode, the reference lies where the axis is, so that the hysteresis
  // follows.
  void follow(const ControlSet& set, std::int32_t counts) {
    feedback_.reset();
    if (torque_) {
      reference_.follow(counts, estimate_.velocity_mps() * set.counts_per_mps);
      return;
    }
    reference_.hold(counts);
    expected_mps2_ = 0.0F;
  }

  void tell(const ReferencePoint& at, float model_N, float feedback_N) {
    out_.reference_counts = at.counts;
    out_.velocity_mps = estimate_.velocity_mps();
    out_.feedforward_N = model_N;
    out_.feedback_N = feedback_N;
  }

  float give_torque(const ReferencePoint& at) {
    // Where the next tick should find the axis.
    out_.reference_counts = sum(at.counts, static_cast<std::int32_t>(at.velocity));
    out_.feedback_N = 0.0F;
    return target_N_.load(std::memory_order_relaxed);
  }

  /// The force that the limited current gives.
  float drive(const ControlSet& set, float wanted_N) {
    const float wanted_A = wanted_N * set.A_per_N;
    const float largest_A = set.axis.current_limit_A;
    // What is not a number is beyond any limit: it is looked for only there.
    if (CurrentLimit::beyond(wanted_A, largest_A) && !finite(wanted_A)) [[unlikely]]
      stop_not_finite(set);
    if (!out_.driving) {
      limit_.reset();
      out_.current_A = 0.0F;
      return wanted_N;
    }
    out_.current_A = limit_.step(largest_A, set.largest_step_A, wanted_A, out_.limits);
    if (reference_.braking()) out_.limits |= kLimitReference;
    return out_.current_A * set.axis.motor_constant_N_per_A;
  }

  static bool finite(float value) {
    // All bits of the exponent set: infinite, or not a number.
    return (std::bit_cast<std::uint32_t>(value) & 0x7F800000U) != 0x7F800000U;
  }

  [[gnu::noinline]] void stop_not_finite(const ControlSet& set) {
    if (out_.driving) state_.raise(Fault::kNotFinite);
    set_mode(set, false, false);
    clear();
  }

  // What a value that is not a number may have reached.
  void clear() {
    blend_N_ = last_wanted_N_ = expected_mps2_ = 0.0F;
    feedback_.clear();
    estimate_.reset(estimate_.counts());
  }

  // Adaptation has time, and new parameters: a tick that has more to do than most leaves both to a later one,
  // so that none has everything.
  void postpone_adaptation() { until_adaptation_ = LevelAdaptation::kEvery + 1; }
  bool busy() const { return until_adaptation_ > LevelAdaptation::kEvery; }

  void adapt(const ControlSet& set, const ReferencePoint& at, float disturbance_mps2) {
    out_.residual_N = -set.mass_kg * disturbance_mps2;
    out_.level = adaptation_.level();
    if (--until_adaptation_ > 0) return;
    until_adaptation_ = LevelAdaptation::kEvery;
    if (out_.limits != 0 || following_) return;
    if (approx::absolute(at.velocity) <= set.adaptation_counts) return;
    adaptation_.step(set.adaptation, feedforward_.dry_N(), out_.residual_N);
  }

  // In the main loop: the points of the reference that the tick has made since the last time.
  void remember() {
    const ControlSet& set = sets_.active();
    const std::uint32_t last = sets_.tick();
    if (!set.valid) remembered_ = last;
    if (set.valid && set.number != memory_number_) {
      memory_.take(set.virgin_curve, set.displacement_shift == memory_shift_);
      memory_number_ = set.number;
      memory_shift_ = set.displacement_shift;
    }
    if (last - remembered_ > kLatest) {
      memory_.miss(last - remembered_ - kLatest);
      remembered_ = last - kLatest;
    }
    while (remembered_ != last) {
      ++remembered_;
      const std::int32_t displacement = FeedForward::displacement(set.scales, delay_[remembered_ % kDelayed]);
      std::atomic_signal_fence(std::memory_order_acquire);
      if (sets_.tick() - remembered_ < kDelayed) {
        memory_.step(displacement);
      } else {
        memory_.miss(1);
      }
    }
  }

  StateMachine state_;
  FaultMonitor monitor_;
  ReferenceGenerator reference_;
  StateEstimate estimate_;
  FeedForward feedforward_;
  Feedback feedback_;
  CurrentLimit limit_;
  LevelAdaptation adaptation_;
  ControlOutput out_;
  float blend_N_ = 0.0F;
  float last_wanted_N_ = 0.0F;
  float expected_mps2_ = 0.0F;
  bool started_ = false;
  bool torque_ = false;    // the force is given
  bool following_ = true;  // the reference is where the axis is
  bool fades_ = false;     // parameters or mode have changed in this tick
  std::uint8_t lead_ = 0;  // ticks
  std::int8_t until_adaptation_ = LevelAdaptation::kEvery;
  std::atomic<std::uint32_t> command_{0};  // control word, kTorqueMode, kReleaseOnFault
  std::atomic<std::uint32_t> events_{0};   // a fault, and kRefused
  std::atomic<float> target_N_{0.0F};
  std::atomic<float> offset_N_{0.0F};
  // Large, or not for the tick: what comes before is near one base address.
  std::array<ReferencePoint, kDelayed> delay_{};
  ParameterSwap<ControlSet> sets_;
  HysteresisMemory memory_;
  std::uint32_t remembered_ = 0;  // the tick whose point memory_ has seen last
  std::uint32_t memory_number_ = 0;
  int memory_shift_ = 0;
};

}  // namespace slipstack
