// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <new>

#include "firmware/control/command_box.h"
#include "firmware/control/control_set.h"
#include "firmware/control/current_limit.h"
#include "firmware/control/cyclic_position.h"
#include "firmware/control/direction_check.h"
#include "firmware/control/fault_monitor.h"
#include "firmware/control/feedback.h"
#include "firmware/control/feedforward.h"
#include "firmware/control/hysteresis_memory.h"
#include "firmware/control/level_adaptation.h"
#include "firmware/control/motion_plan.h"
#include "firmware/control/parameter_swap.h"
#include "firmware/control/point_to_point.h"
#include "firmware/control/reference.h"
#include "firmware/control/state_estimate.h"
#include "firmware/control/state_machine.h"
#include "firmware/control/thermal_limit.h"

namespace slipstack {

/// What the controller publishes after each tick.
struct ControlOutput {
  float current_A = 0.0F;
  bool driving = false;      ///< false: power stage off
  std::uint16_t limits = 0;  ///< bits of Limit
  std::int32_t reference_counts = 0;
  float position_error_m = 0.0F;  ///< reference less estimate
  float velocity_mps = 0.0F;      ///< estimated
  float feedforward_N = 0.0F;     ///< model on the reference, level included; in torque mode not applied
  float feedback_N = 0.0F;        ///< in position mode only
  float residual_N = 0.0F;        ///< force that the model misses, from the disturbance observer
  float level = 1.0F;             ///< adapted friction level
};

/// What the tick does with the motor.
enum class ControlMode : std::uint8_t {
  kOff,       ///< power stage off; the reference lies where the axis is
  kPosition,  ///< the axis follows the reference; also while it is braked under control
  kTorque,    ///< the force is commanded; the reference follows the axis
};

/// One axis: from encoder counts to a current. In position mode
///
///   F = model(reference) + level change + notch(Kv (v_ref + Kp e - v) + integral) - share x disturbance
///       + offset
///
/// The model sees the reference, never the measurement: it is a feed-forward, and whatever it or its
/// adaptation does, the loop that could become unstable is that of the linear feedback (docs/control.md).
///
/// In torque mode F = target + offset. The reference then follows the axis, and with it the hysteresis; a
/// stop begins at the axis's own velocity. A change between the two modes fades as one of parameters does.
class Controller {
 public:
  /// Outside the tick: checks and prepares new parameters; they are in force from the next tick on, or
  /// a later one (call poll() from the main loop). Refused parameters change nothing, and stop an enabled
  /// axis.
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
  /// Outside the tick, while the axis is not driven: from the next tick on there are no parameters, and the
  /// axis cannot be enabled before configure(), which may then change resolution and tick too. False while
  /// another change is pending.
  bool withdraw_parameters() {
    ControlSet* spare = sets_.spare();
    if (spare == nullptr) return false;
    ::new (static_cast<void*>(spare)) ControlSet;  // in place: a copy would not fit the stack
    spare->number = sets_.active().number + 1;
    sets_.arm();
    return true;
  }
  /// From the main loop, at least every kLatest ticks: a change of parameters that a tick has missed, and the
  /// memory of the hysteresis.
  void poll() {
    if (sets_.pending()) sets_.arm();
    remember();
    watch_load();
  }
  bool change_pending() const { return sets_.pending(); }

  /// Outside the tick: the control word 6040h.
  void command(std::uint16_t control_word) {
    command_all((command_.read().word & 0xFFFF0000U) | control_word);
  }
  /// Outside the tick: the same with kTorqueMode and what follows it.
  void command_all(std::uint32_t word) {
    const Command& now = command_.read();
    command(Command{word, now.target_N, now.offset_N});
  }
  /// Outside the tick: control word and forces at once.
  void command(const Command& command) { command_.write(command); }
  /// Outside the tick: a command of the master came; those that supervision waits for are younger than
  /// `timeout_ticks`.
  void commanded(std::uint32_t timeout_ticks) {
    command_timeout_.store(timeout_ticks, std::memory_order_relaxed);
    commanded_at_.store(sets_.tick(), std::memory_order_relaxed);
    command_lost_.store(false, std::memory_order_release);
  }
  /// The time of supervised commands ran out, and none came since.
  bool command_lost() const { return command_lost_.load(std::memory_order_acquire); }
  /// Outside the tick: the force in torque mode, and the force that is added in every mode, N.
  void set_torque(float target_N, float offset_N) {
    command(Command{command_.read().word, target_N, offset_N});
  }
  /// Outside the tick: retargets the reference, within the limits of the axis, from whatever state it is in.
  PlanStatus move_to(std::int32_t counts) { return move_to(counts, parameters().motion); }
  /// The same within narrower limits; what is wider is not taken.
  PlanStatus move_to(std::int32_t counts, const MotionLimits& limits) {
    return point_to_point_.move(reference_, counts, within_axis(limits), parameters().braking);
  }
  /// Outside the tick: to rest, within these limits.
  PlanStatus halt(const MotionLimits& limits) {
    return point_to_point_.halt(reference_, within_axis(limits), parameters().braking);
  }
  ReferenceGenerator& reference() { return reference_; }
  const ReferenceGenerator& reference() const { return reference_; }
  CyclicPosition& cyclic_position() { return cyclic_position_; }
  const CyclicPosition& cyclic_position() const { return cyclic_position_; }
  /// Outside the tick: a fault found elsewhere, as a reset by the watchdog; seen by the next tick.
  void inject(Fault fault) { events_.store(static_cast<std::uint32_t>(fault), std::memory_order_release); }

  /// In the tick.
  const ControlOutput& step(const TickInputs& in) {
    const bool new_parameters = sets_.begin_tick();
    ControlSet& set = sets_.active();
    if (new_parameters) begin_with(set, in.encoder.counts);
    supervise(set, in);
    const ControlMode before = mode_;
    change_mode(requested_mode());
    const bool fade = new_parameters || (mode_ != before && before != ControlMode::kOff);
    out_.limits = 0;
    switch (mode_) {
      case ControlMode::kOff:
        stay_off(set, in.encoder.counts);
        break;
      case ControlMode::kPosition:
        control_position(set, in.encoder.counts, fade);
        break;
      case ControlMode::kTorque:
        control_torque(set, in.encoder.counts, fade);
        break;
    }
    out_.driving = mode_ != ControlMode::kOff;
    return out_;
  }

  const ControlOutput& output() const { return out_; }
  /// Current flows: also before operation is enabled, in the check of the direction.
  bool driving() const { return out_.driving || state_.driving(); }
  /// I2t, as of the last poll().
  const ThermalLimit& thermal() const { return thermal_; }
  /// The check of the direction is still to be passed.
  bool direction_unknown() const { return check_.pending(); }
  const FrictionModel<float>::Force& friction() const { return sets_.active().model.force(); }
  /// As far as the last poll() has followed the tick.
  const HysteresisMemory& memory() const { return memory_; }
  const StateMachine& state() const { return state_; }
  const StateEstimate& estimate() const { return estimate_; }
  /// The readings of the last tick.
  std::int32_t measured_counts() const { return monitor_.last_counts(); }
  float measured_A() const { return monitor_.last_A(); }
  const ControlSet& parameters() const { return sets_.active(); }
  std::uint32_t ticks() const { return sets_.tick(); }

 private:
  static constexpr std::uint32_t kRefused = 0x100;  // in events_, beside the number of a fault
  static constexpr std::uint32_t kDelayed = 64;
  static constexpr int kNoShift = 99;  // displacement has no unit yet
  static_assert(kLargestLeadTicks < static_cast<std::int32_t>(kDelayed));

 public:
  /// How many ticks poll() may be late without missing one.
  static constexpr std::uint32_t kLatest = kDelayed - 8;

 private:
  MotionLimits within_axis(const MotionLimits& limits) const {
    const MotionLimits& axis = parameters().motion;
    return {std::min(limits.velocity, axis.velocity), std::min(limits.acceleration, axis.acceleration),
            std::min(limits.deceleration, axis.deceleration), std::min(limits.jerk, axis.jerk)};
  }

  // The first tick of new parameters.
  void begin_with(const ControlSet& set, std::int32_t counts) {
    adaptation_.limit(set.adaptation);
    check_.begin(set.direction);
    largest_A_.store(set.axis.current_limit_A, std::memory_order_relaxed);
    const bool starts = set.valid && !started_;
    started_ = set.valid;
    if (!starts) return;
    estimate_.reset(counts);
    monitor_.reset(counts);
  }

  // Faults and commands to the state machine; the reference brakes where its new state asks for it.
  void supervise(ControlSet& set, const TickInputs& in) {
    Fault fault = Fault::kNone;
    if (set.valid) {
      fault = monitor_.check(set.monitor, in, out_.reference_counts, limit_.last_A(), out_.driving);
    } else {
      set.start_counts = in.encoder.counts;
      monitor_.reset(in.encoder.counts);
    }
    if (events_.load(std::memory_order_relaxed) != 0) fault = with_event(fault);
    std::uint32_t command = supervised_command();
    if (check_.pending()) [[unlikely]] {
      fault = check_direction(set, in.encoder.counts, command, fault);
      if (check_.pushing()) command &= ~std::uint32_t{kEnableOperation};
    }
    state_.step(command, fault, set.valid, reference_.standing(), set.stop_timeout_ticks);
    if (state_.braking() && !reference_.braking() && !reference_.standing()) reference_.stop();
  }

  // The command, without the bits that a lost master takes back. In the tick, so that the axis stops even if
  // the main loop stands still.
  std::uint32_t supervised_command() {
    const std::uint32_t command = command_.read().word;
    const std::uint32_t reaction = (command & (kLostDisables | kLostStops)) >> kReactionShift;
    const std::uint32_t age = sets_.tick() - commanded_at_.load(std::memory_order_relaxed);
    if (reaction == 0 || age <= command_timeout_.load(std::memory_order_relaxed)) return command;
    command_lost_.store(true, std::memory_order_relaxed);
    return command & ~reaction;
  }

  // Operation is not enabled before the direction is known: while it is asked for, the axis is pushed.
  [[gnu::noinline]] Fault check_direction(const ControlSet& set, std::int32_t counts, std::uint32_t command,
                                          Fault fault) {
    constexpr std::uint32_t kEnable = kSwitchOn | kEnableVoltage | kQuickStop | kEnableOperation;
    const bool asked = state_.state() == DriveState::kSwitchedOn && fault == Fault::kNone &&
                       (command & (kEnable | kFaultReset)) == kEnable;
    if (!asked) {
      check_.rest();
      return fault;
    }
    switch (check_.step(set.direction, counts)) {
      case DirectionCheck::Verdict::kReversed:
        return Fault::kDirection;
      case DirectionCheck::Verdict::kBlocked:
        return Fault::kStall;
      default:
        return fault;
    }
  }

  // What came from outside the tick: an injected fault, or parameters that were refused.
  Fault with_event(Fault fault) {
    const std::uint32_t event = events_.exchange(0, std::memory_order_acquire);
    const auto injected = static_cast<Fault>(event & 0xFFU);
    if (injected != Fault::kNone) return injected;
    return out_.driving && fault == Fault::kNone ? Fault::kParameter : fault;
  }

  ControlMode requested_mode() const {
    if (!state_.driving()) return check_.pushing() ? ControlMode::kTorque : ControlMode::kOff;
    return state_.torque_mode() ? ControlMode::kTorque : ControlMode::kPosition;
  }

  void change_mode(ControlMode mode) {
    if (mode == mode_) return;
    // Out of torque mode the axis is braked from its own velocity, then holds its position.
    if (mode_ == ControlMode::kTorque && mode == ControlMode::kPosition && !reference_.braking())
      reference_.stop();
    if (mode == ControlMode::kOff) {
      limit_.reset();
      blend_N_ = 0.0F;
    }
    feedback_.reset();
    mode_ = mode;
  }

  // Power stage off: the reference lies where the axis is, so that the hysteresis follows.
  void stay_off(ControlSet& set, std::int32_t counts) {
    reference_.hold(counts);
    expected_mps2_ = 0.0F;
    estimate_.step(set.estimate, counts, expected_mps2_);
    publish(set, reference_at(0), step_model(set));
    out_.current_A = 0.0F;
  }

  void control_position(ControlSet& set, std::int32_t counts, bool fade) {
    estimate_.step(set.estimate, counts, expected_mps2_);
    const float model_N = step_model(set);
    const ReferencePoint& now = reference_at(set.lead);
    publish(set, now, model_N);
    out_.feedback_N = feedback_.step(set.feedback, now, out_.position_error_m, estimate_.velocity_mps());
    const float disturbance_N = set.disturbance_kg * estimate_.disturbance_mps2();
    const Applied force = apply(set, model_N + out_.feedback_N - disturbance_N, fade);
    expect(set, now, force.applied_N - model_N);
    feedback_.integrate(set.feedback, force.applied_N, force.wanted_N);
    adapt(set, now);
  }

  void control_torque(ControlSet& set, std::int32_t counts, bool fade) {
    reference_.follow(counts, estimate_.velocity_mps() * set.counts_per_mps);
    estimate_.step(set.estimate, counts, expected_mps2_);
    const float model_N = step_model(set);
    const ReferencePoint& now = reference_at(0);
    publish(set, now, model_N);
    // Where the next tick should find the axis.
    out_.reference_counts = sum(now.counts, static_cast<std::int32_t>(now.velocity));
    const Command& command = command_.read();
    // The push alone: an offset is for an axis that is known.
    const float force_N = check_.pushing() ? check_.force_N() - command.offset_N : command.target_N;
    const Applied force = apply(set, force_N, fade);
    expect(set, now, force.applied_N - model_N);
  }

  // The next point of the reference, and the force of the model there.
  float step_model(ControlSet& set) {
    const std::uint32_t tick = sets_.tick();
    ReferencePoint& ahead = delay_[tick % kDelayed];
    const bool streamed = mode_ == ControlMode::kPosition && !state_.braking() && cyclic_position_.step(tick);
    ahead =
        streamed ? reference_.track(cyclic_position_.point(), set.tracking) : reference_.next(set.braking);
    return feedforward_.step(set.model, set.scales, ahead, tick, adaptation_.level());
  }

  // The point that the model saw `lead` ticks ago. Before the axis follows its reference there is no history
  // worth waiting for: the lead is then 0.
  const ReferencePoint& reference_at(std::int32_t lead) const {
    return delay_[(sets_.tick() - static_cast<std::uint32_t>(lead)) % kDelayed];
  }

  void publish(const ControlSet& set, const ReferencePoint& at, float model_N) {
    out_.reference_counts = at.counts;
    out_.position_error_m = Feedback::error_m(set.feedback, at, estimate_);
    out_.velocity_mps = estimate_.velocity_mps();
    out_.feedforward_N = model_N;
    out_.feedback_N = 0.0F;
    out_.residual_N = -set.mass_kg * estimate_.disturbance_mps2();
    out_.level = adaptation_.level();
  }

  struct Applied {
    float wanted_N;
    float applied_N;  // what the limits of the current leave of it
  };

  // Offset, fading and limits; the current that gives the force. `fade`: the wanted force may step in this
  // tick, since parameters or the mode have changed.
  [[gnu::always_inline]] Applied apply(ControlSet& set, float force_N, bool fade) {
    float wanted_N = force_N + command_.read().offset_N;
    if (fade) blend_N_ = out_.driving ? last_wanted_N_ - wanted_N : 0.0F;
    wanted_N += blend_N_;
    blend_N_ *= set.blend_keep;
    last_wanted_N_ = wanted_N;
    const float wanted_A = wanted_N * set.A_per_N;
    if (!approx::is_finite(wanted_A)) return stop_not_finite(set);
    out_.current_A =
        limit_.step(largest_A_.load(std::memory_order_relaxed), set.largest_step_A, wanted_A, out_.limits);
    if (reference_.braking()) out_.limits |= kLimitReference;
    return {wanted_N, out_.current_A * set.axis.motor_constant_N_per_A};
  }

  // No current. What the value may have reached is reset: here, and by the change of mode.
  Applied stop_not_finite(ControlSet& set) {
    state_.raise(Fault::kNotFinite);
    change_mode(ControlMode::kOff);
    out_.current_A = 0.0F;
    estimate_.reset(estimate_.counts());
    set.forget_motion(estimate_.counts());
    return {0.0F, 0.0F};
  }

  // The acceleration that the state estimate shall expect: that of the reference, and what a force beyond the
  // model adds.
  void expect(const ControlSet& set, const ReferencePoint& at, float excess_N) {
    expected_mps2_ = at.acceleration * set.mps2_per_count + excess_N * set.per_mass_kg;
  }

  // A limit that is active, or a reference near rest, says nothing about the level of the friction.
  void adapt(const ControlSet& set, const ReferencePoint& at) {
    if (out_.limits != 0) return;
    if (approx::absolute(at.velocity) <= set.adaptation_counts) return;
    adaptation_.step(set.adaptation, feedforward_.dry_N(), out_.residual_N);
  }

  // In the main loop: the points of the reference that the tick has made since the last time.
  void remember() {
    const ControlSet& set = sets_.active();
    const std::uint32_t last = sets_.tick();
    if (!set.valid) {
      remembered_ = last;
      memory_shift_ = kNoShift;
    }
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

  // In the main loop: the heat of a sample of the current, as often as the loop turns.
  void watch_load() {
    const ControlSet& set = sets_.active();
    const std::uint32_t now = sets_.tick();
    const auto elapsed_s = static_cast<float>(now - load_tick_) * set.axis.tick_s;
    load_tick_ = now;
    if (!set.valid) return;
    thermal_.step(set.axis, elapsed_s, driving() ? measured_A() : 0.0F);
    largest_A_.store(thermal_.limit_A(), std::memory_order_relaxed);
    const bool first = !was_spent_ && thermal_.spent();
    was_spent_ = thermal_.spent();
    if (first && set.axis.overload_is_fault && driving()) inject(Fault::kOverload);
  }

  StateMachine state_;
  FaultMonitor monitor_;
  DirectionCheck check_;
  ReferenceGenerator reference_;
  CyclicPosition cyclic_position_;
  PointToPoint point_to_point_;
  StateEstimate estimate_;
  FeedForward feedforward_;
  Feedback feedback_;
  CurrentLimit limit_;
  LevelAdaptation adaptation_;
  ControlOutput out_;
  ControlMode mode_ = ControlMode::kOff;
  bool started_ = false;
  float blend_N_ = 0.0F;
  float last_wanted_N_ = 0.0F;
  float expected_mps2_ = 0.0F;
  CommandBox command_;
  std::atomic<std::uint32_t> commanded_at_{0};  // the tick of the last command
  std::atomic<std::uint32_t> command_timeout_{0};
  std::atomic<bool> command_lost_{false};
  std::atomic<std::uint32_t> events_{0};  // a fault, and kRefused
  std::array<ReferencePoint, kDelayed> delay_{};
  ParameterSwap<ControlSet> sets_;
  HysteresisMemory memory_;
  std::uint32_t remembered_ = 0;  // the tick whose point memory_ has seen last
  std::uint32_t memory_number_ = 0;
  int memory_shift_ = kNoShift;
  ThermalLimit thermal_;
  std::atomic<float> largest_A_{0.0F};  // current limit of the axis, less where I2t is spent
  std::uint32_t load_tick_ = 0;
  bool was_spent_ = false;
};

}  // namespace slipstack
