// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <new>

#include "firmware/control/command_box.h"
#include "firmware/control/control_set.h"
#include "firmware/control/current_limit.h"
#include "firmware/control/cyclic_position.h"
#include "firmware/control/digital_io.h"
#include "firmware/control/direction_check.h"
#include "firmware/control/fault_monitor.h"
#include "firmware/control/feedback.h"
#include "firmware/control/feedforward.h"
#include "firmware/control/hysteresis_memory.h"
#include "firmware/control/level_adaptation.h"
#include "firmware/control/parameter_swap.h"
#include "firmware/control/point_to_point.h"
#include "firmware/control/position_latch.h"
#include "firmware/control/position_reference.h"
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
  kPush,      ///< the force is that of the direction check, before operation is enabled
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
    const ParameterStatus status = spare->prepare(axis, model, user_bounds_);
    if (status == ParameterStatus::kOk) {
      spare->model.refresh(time_s_);
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
    fade_position();
    check_index();
    remember();
    watch_load();
  }
  bool change_pending() const { return sets_.pending(); }

  /// Outside the tick: bounds of motion beside those of the axis; in force from the next tick on.
  void bound(const UserBounds& user) {
    const std::uint32_t number = user_bounds_.number + 1;
    user_bounds_ = user;
    user_bounds_.number = number;
    sets_.each([this](ControlSet& set) { set.bound(user_bounds_); });
  }
  const UserBounds& user_bounds() const { return user_bounds_; }

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
  /// Outside the tick, and again after a change of parameters: what 60FEh asks of the digital outputs.
  void set_outputs(std::uint32_t wanted) {
    const IoMasks& io = parameters().io;
    outputs_driven_.store(output_levels(io, wanted, true), std::memory_order_relaxed);
    outputs_off_.store(output_levels(io, wanted, false), std::memory_order_relaxed);
  }
  /// Outside the tick: retargets the reference, within the limits of the axis, from whatever state it is in.
  PlanStatus move_to(std::int32_t counts) { return move_to(counts, bounds().motion); }
  /// The same within narrower limits; what is wider is not taken.
  PlanStatus move_to(std::int32_t counts, const MotionLimits& limits) {
    return point_to_point_.move(reference_, counts, within_axis(limits), ramp(bounds()), range(),
                                position_.origin());
  }
  /// Outside the tick: moves in this direction (1 or -1) until something else is commanded, 2^31 counts at
  /// the most.
  PlanStatus search(std::int32_t direction, const MotionLimits& limits) {
    constexpr std::int32_t kFarthest = 0x7FFFFFFF;
    const std::int32_t from = reference_.counts();
    return point_to_point_.move(reference_, sum(from, direction * kFarthest), within_axis(limits),
                                ramp(bounds()), {}, from);
  }
  /// Outside the tick: to rest, within these limits.
  PlanStatus halt(const MotionLimits& limits) {
    return point_to_point_.halt(reference_, within_axis(limits), ramp(bounds()));
  }
  ReferenceGenerator& reference() { return reference_; }
  const ReferenceGenerator& reference() const { return reference_; }
  /// Where position zero lies in counts.
  PositionReference& position() { return position_; }
  const PositionReference& position() const { return position_; }
  /// Of homing; armed outside the tick.
  PositionLatch& latch() { return latch_; }
  CyclicPosition& cyclic_position() { return cyclic_position_; }
  const CyclicPosition& cyclic_position() const { return cyclic_position_; }
  /// Outside the tick: a fault found elsewhere, as a reset by the watchdog; seen by the next tick.
  void inject(Fault fault) { events_.store(static_cast<std::uint32_t>(fault), std::memory_order_release); }

  /// In the tick, before its step: an index mark passed at these counts.
  void index_passed(std::int32_t counts) {
    latch_.index_passed(counts);
    position_.index_passed(counts);
  }

  /// In the tick.
  const ControlOutput& step(const TickInputs& in) {
    const bool new_parameters = sets_.begin_tick();
    ControlSet& set = sets_.active();
    if (new_parameters) begin_with(set, in.encoder.counts);
    inputs_ = DigitalInputs(in.digital);
    if (latch_.armed()) [[unlikely]]
      latch_.step(inputs_, set.io, in.encoder.counts);
    const MotionBounds& bounds = set.bounds.read();
    out_.limits = 0;
    follow_range(set, bounds, in.encoder.counts);
    supervise(set, bounds, in);
    const ControlMode before = mode_;
    change_mode(requested_mode());
    const bool fade = new_parameters || (mode_ != before && before != ControlMode::kOff);
    switch (mode_) {
      case ControlMode::kOff:
        stay_off(set, bounds, in.encoder.counts);
        break;
      case ControlMode::kPosition:
        control_position(set, bounds, in.encoder.counts, fade);
        break;
      case ControlMode::kTorque:
        control_torque(set, bounds, in.encoder.counts, fade);
        break;
      case ControlMode::kPush:
        push(set, bounds, in.encoder.counts, fade);
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
  /// Levels of the output terminals, the brake as the state has it.
  std::uint32_t digital_outputs() const {
    return (state_.brake_released() || check_.pushing() ? outputs_driven_ : outputs_off_)
        .load(std::memory_order_relaxed);
  }
  /// Of the last tick; what they mean is in parameters().io.
  const DigitalInputs& inputs() const { return inputs_; }
  /// The readings of the last tick.
  std::int32_t measured_counts() const { return monitor_.last_counts(); }
  float measured_A() const { return monitor_.last_A(); }
  /// Outside the tick: where the axis may be.
  PositionRange range() const { return bounds().range.and_within(at_switches_); }
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
  const MotionBounds& bounds() const { return parameters().bounds.read(); }

  // Of a stop that is under way, or would begin now.
  const BrakingLimits& ramp(const MotionBounds& bounds) const {
    return state_.slows_down() ? bounds.slow_down : bounds.quick_stop;
  }

  MotionLimits within_axis(const MotionLimits& limits) const {
    const MotionLimits& axis = bounds().motion;
    return {std::min(limits.velocity, axis.velocity), std::min(limits.acceleration, axis.acceleration),
            std::min(limits.deceleration, axis.deceleration), std::min(limits.jerk, axis.jerk)};
  }

  // The first tick of new parameters.
  void begin_with(const ControlSet& set, std::int32_t counts) {
    check_.begin(set.direction);
    largest_A_.store(set.axis.current_limit_A, std::memory_order_relaxed);
    const bool starts = set.valid && !started_;
    started_ = set.valid;
    if (!starts) return;
    estimate_.reset(counts);
    monitor_.reset(counts);
    position_.start(set.axis.reference);
  }

  // The ends of the range: those of the user, and where a limit switch became active. There the reference
  // brakes.
  void follow_range(const ControlSet& set, const MotionBounds& bounds, std::int32_t counts) {
    const std::uint32_t active = bounds.switches ? inputs_.limits(set.io) : 0U;
    if (active != active_limits_ || bounds.number != range_number_) [[unlikely]]
      change_range(set.io, bounds, active, counts);
    if (active == 0) return;
    out_.limits |= kLimitSwitch;
    const bool outwards =
        (active & (reference_.forward() ? set.io.positive_limit : set.io.negative_limit)) != 0;
    if (outwards && reference_.playing()) reference_.stop();
  }

  void change_range(const IoMasks& io, const MotionBounds& bounds, std::uint32_t active,
                    std::int32_t counts) {
    const std::uint32_t changed = active ^ active_limits_;
    if ((changed & io.positive_limit) != 0)
      at_switches_.highest = (active & io.positive_limit) != 0 ? counts : PositionRange::kNoHighest;
    if ((changed & io.negative_limit) != 0)
      at_switches_.lowest = (active & io.negative_limit) != 0 ? counts : PositionRange::kNoLowest;
    active_limits_ = active;
    range_number_ = bounds.number;
    range_ = bounds.range.and_within(at_switches_);
  }

  // Faults and commands to the state machine; the reference brakes where its new state asks for it.
  void supervise(ControlSet& set, const MotionBounds& bounds, const TickInputs& in) {
    Fault fault = Fault::kNone;
    if (set.valid) {
      fault = monitor_.check(set.monitor, in, out_.reference_counts, limit_.last_A(), out_.driving);
    } else {
      set.start_counts = in.encoder.counts;
      monitor_.reset(in.encoder.counts);
    }
    if (!inputs_.amplifier_well(set.io)) [[unlikely]]
      fault = with_amplifier(set, fault);
    if (events_.load(std::memory_order_relaxed) != 0) fault = with_event(fault);
    std::uint32_t command = supervised_command();
    if (check_.pending()) [[unlikely]]
      fault = check_direction(set, bounds, in.encoder.counts, command, fault);
    // An absolute encoder that works again knows its place; an incremental one has to be homed.
    if (loses_place(fault) && !set.axis.reference.absolute_encoder) [[unlikely]]
      position_.lose();
    state_.step(
        command, fault, set.valid, [this] { return reference_.standing(); }, bounds.times);
    if (!state_.braking()) return;
    if (state_.takes_axis_over()) return take_axis_over(set, in.encoder.counts);
    if (!reference_.braking() && !reference_.standing()) reference_.stop();
  }

  // The reference is away from the axis, or what moves it is in doubt: it begins anew where the axis is, and
  // as the axis moves. It brakes from the next tick on.
  void take_axis_over(const ControlSet& set, std::int32_t counts) {
    // The estimate lags behind a push; the last step is right to a count.
    const auto step = static_cast<float>(monitor_.last_step());
    const float velocity =
        approx::clamp(estimate_.velocity_mps() * set.counts_per_mps, step - 1.0F, step + 1.0F);
    estimate_.correct_velocity(velocity * set.mps_per_count);
    reference_.follow(counts, velocity);
    feedback_.reset();
    blend_N_ = 0.0F;
    history_from_ = sets_.tick();
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
  [[gnu::noinline]] Fault check_direction(const ControlSet& set, const MotionBounds& bounds,
                                          std::int32_t counts, std::uint32_t& command, Fault fault) {
    constexpr std::uint32_t kEnable = kSwitchOn | kEnableVoltage | kQuickStop | kEnableOperation;
    const bool asked = state_.state() == DriveState::kSwitchedOn && fault == Fault::kNone &&
                       (command & (kEnable | kFaultReset)) == kEnable;
    if (!asked) {
      check_.rest();
      return fault;
    }
    const DirectionCheck::Verdict verdict = check_.step(set.direction, bounds.times.brake_release, counts);
    if (verdict == DirectionCheck::Verdict::kReversed) return Fault::kDirection;
    if (verdict == DirectionCheck::Verdict::kBlocked) return Fault::kStall;
    if (check_.pushing()) command &= ~std::uint32_t{kEnableOperation};
    return fault;
  }

  // What the amplifier reports explains what else is seen of it.
  Fault with_amplifier(const ControlSet& set, Fault fault) const {
    if (inputs_.amplifier_fault(set.io)) return Fault::kAmplifierFault;
    return out_.driving ? Fault::kAmplifierNotReady : fault;
  }

  // What came from outside the tick: an injected fault, or parameters that were refused.
  Fault with_event(Fault fault) {
    const std::uint32_t event = events_.exchange(0, std::memory_order_acquire);
    const auto injected = static_cast<Fault>(event & 0xFFU);
    if (injected != Fault::kNone) return injected;
    return out_.driving && fault == Fault::kNone ? Fault::kParameter : fault;
  }

  ControlMode requested_mode() {
    const bool torque = state_.torque_mode();
    if (!torque) held_ = 0;
    if (!state_.driving()) return check_.pushing() ? ControlMode::kPush : ControlMode::kOff;
    if (!torque) return ControlMode::kPosition;
    if (held_ == 0) return ControlMode::kTorque;
    return stay_held();
  }

  // At an end of the position range, until the axis stands and the force points away from it.
  ControlMode stay_held() {
    const Command& command = command_.read();
    const bool inwards = static_cast<float>(held_) * (command.target_N + command.offset_N) <= 0.0F;
    if (mode_ == ControlMode::kPosition && inwards && reference_.standing()) {
      held_ = 0;
      return ControlMode::kTorque;
    }
    out_.limits |= kLimitPosition;
    return ControlMode::kPosition;
  }

  void change_mode(ControlMode mode) {
    if (mode == mode_) return;
    // Out of torque mode the axis is braked from its own velocity, then holds its position.
    const bool followed = mode_ == ControlMode::kTorque || mode_ == ControlMode::kPush;
    if (followed && mode == ControlMode::kPosition && !reference_.braking()) reference_.stop();
    if (mode == ControlMode::kOff) {
      limit_.reset();
      blend_N_ = 0.0F;
    }
    feedback_.reset();
    mode_ = mode;
  }

  // Power stage off: the reference lies where the axis is, so that the hysteresis follows.
  void stay_off(ControlSet& set, const MotionBounds& bounds, std::int32_t counts) {
    reference_.hold(counts);
    expected_mps2_ = 0.0F;
    estimate_.step(set.estimate, counts, expected_mps2_);
    publish(set, reference_at(0), step_model(set, bounds));
    out_.current_A = 0.0F;
  }

  void control_position(ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade) {
    estimate_.step(set.estimate, counts, expected_mps2_);
    const float model_N = step_model(set, bounds);
    const ReferencePoint& now = reference_at(lead_of(set));
    publish(set, now, model_N);
    out_.feedback_N = feedback_.step(set.feedback, now, out_.position_error_m, estimate_.velocity_mps());
    const float disturbance_N = set.disturbance_kg * estimate_.disturbance_mps2();
    const Applied force = apply(set, model_N + out_.feedback_N - disturbance_N, fade);
    expect(set, now, force.applied_N - model_N);
    feedback_.integrate(set.feedback, force.applied_N, force.wanted_N);
    adapt(set, now);
  }

  void control_torque(ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade) {
    const float model_N = follow_axis(set, bounds, counts);
    const float target_N = within_velocity(set, bounds.velocity_mps, command_.read().target_N);
    const Applied force = apply(set, target_N, fade);
    expect(set, reference_at(0), force.applied_N - model_N);
    held_ = end_ahead(set, bounds, counts);
  }

  // The push alone: an offset is for an axis that is known. What it may do to the axis is bounded by itself.
  [[gnu::noinline]] void push(ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade) {
    const float model_N = follow_axis(set, bounds, counts);
    const Applied force = apply(set, check_.force_N() - command_.read().offset_N, fade);
    expect(set, reference_at(0), force.applied_N - model_N);
  }

  // The reference is where the axis is; the force of the model there.
  [[gnu::always_inline]] float follow_axis(ControlSet& set, const MotionBounds& bounds, std::int32_t counts) {
    reference_.follow(counts, estimate_.velocity_mps() * set.counts_per_mps);
    estimate_.step(set.estimate, counts, expected_mps2_);
    const float model_N = step_model(set, bounds);
    const ReferencePoint& now = reference_at(0);
    publish(set, now, model_N);
    // Where the next tick should find the axis.
    out_.reference_counts = sum(now.counts, static_cast<std::int32_t>(now.velocity));
    return model_N;
  }

  // The force fades to zero towards the largest velocity, and brakes beyond it, as the velocity loop does.
  float within_velocity(const ControlSet& set, float largest_mps, float target_N) {
    const float gain = set.feedback.velocity_N_s_per_m;
    const float v = estimate_.velocity_mps();
    const float limited_N = approx::clamp(target_N, gain * (-largest_mps - v), gain * (largest_mps - v));
    if (gain == 0.0F || limited_N == target_N) return target_N;
    out_.limits |= kLimitVelocity;
    return limited_N;
  }

  // In torque mode, an end of the position range ahead: which, if the axis must be braked from the next tick
  // on to rest there, or stands there and is pushed out.
  std::int8_t end_ahead(const ControlSet& set, const MotionBounds& bounds, std::int32_t counts) const {
    const Command& command = command_.read();
    const float force_N = command.target_N + command.offset_N;
    const float velocity = estimate_.velocity_mps() * set.counts_per_mps;
    const float speed = approx::absolute(velocity);
    const bool forward = (speed >= 1.0F ? velocity : force_N) > 0.0F;
    const float room = range_.room(counts, forward);
    const float acceleration = expected_mps2_ / set.mps2_per_count;
    const float outwards = forward ? acceleration : -acceleration;
    // Three ticks: that of the estimate, this one, and the one that brakes.
    const float needed = bounds.stopping.from(speed, outwards > 0.0F ? outwards : 0.0F) + 3.0F * speed;
    if (room > needed || (speed < 1.0F && force_N == 0.0F)) return 0;
    return forward ? 1 : -1;
  }

  // The next point of the reference, and the force of the model there.
  float step_model(ControlSet& set, const MotionBounds& bounds) {
    const std::uint32_t tick = sets_.tick();
    ReferencePoint& ahead = delay_[tick % kDelayed];
    const bool streamed = mode_ == ControlMode::kPosition && !state_.braking() && cyclic_position_.step(tick);
    ahead = streamed ? reference_.track(stream_point(), bounds.tracking) : reference_.next(ramp(bounds));
    const float force_N = feedforward_.step(set.model, set.scales, ahead, adaptation_.level(), position_);
    residuals_[tick % kDelayed] = {feedforward_.dry_N(), std::numeric_limits<float>::quiet_NaN()};
    return force_N;
  }

  // At a limit switch nothing of the stream that is beyond it counts any more, however far ahead it is.
  StreamPoint stream_point() const {
    const StreamPoint point = cyclic_position_.point();
    if (active_limits_ == 0) [[likely]]
      return point;
    const std::int32_t allowed = range_.nearest(point.counts);
    return allowed == point.counts ? point : StreamPoint{.counts = allowed};
  }

  // What was before the axis has been taken over is not waited for.
  std::int32_t lead_of(const ControlSet& set) const {
    const std::uint32_t history = sets_.tick() - history_from_;
    return history < static_cast<std::uint32_t>(set.lead) ? static_cast<std::int32_t>(history) : set.lead;
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

  // What a tick says about the level of the friction, for the main loop: nothing where a limit is active or
  // the reference is near rest.
  void adapt(const ControlSet& set, const ReferencePoint& at) {
    if (out_.limits != 0) return;
    if (approx::absolute(at.velocity) <= set.adaptation_counts) return;
    residuals_[sets_.tick() % kDelayed].residual_N = out_.residual_N;
  }

  // In the main loop: no mark comes again before it.
  void check_index() {
    if (!position_.check_index(parameters().axis.reference)) inject(Fault::kIndexOffPlace);
  }

  // In the main loop: effects over position come and go over the same time as parameters do.
  void fade_position() {
    const std::uint32_t last = sets_.tick();
    const std::uint32_t passed = last - faded_;
    faded_ = last;
    const AxisParameters& axis = parameters().axis;
    position_.fade(out_.driving ? static_cast<float>(passed) * axis.tick_s / axis.swap_time_s : 1.0F);
  }

  // In the main loop: what the tick has made since the last time, the level of the friction and the points of
  // the reference.
  void remember() {
    const ControlSet& set = sets_.active();
    const std::uint32_t last = sets_.tick();
    if (set.valid) adaptation_.limit(set.adaptation);
    time_s_ = up_time_.at(last, set.axis.tick_s);
    sets_.active().model.refresh(time_s_);
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
      const Residual residual = residuals_[remembered_ % kDelayed];
      std::atomic_signal_fence(std::memory_order_acquire);
      if (sets_.tick() - remembered_ < kDelayed) {
        memory_.step(displacement);
        if (set.valid) adaptation_.step(set.adaptation, residual.dry_N, residual.residual_N);
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

  // What the tick uses most comes first: a single load instruction reaches it (1020 bytes, Armv7E-M VLDR).
  StateMachine state_;
  FaultMonitor monitor_;
  ControlOutput out_;
  ControlMode mode_ = ControlMode::kOff;
  bool started_ = false;
  std::int8_t held_ = 0;  // in torque mode, at an end of the position range: which
  StateEstimate estimate_;
  FeedForward feedforward_;
  Feedback feedback_;
  CurrentLimit limit_;
  std::atomic<float> largest_A_{0.0F};  // current limit of the axis, less where I2t is spent
  float blend_N_ = 0.0F;
  float last_wanted_N_ = 0.0F;
  float expected_mps2_ = 0.0F;
  LevelAdaptation adaptation_;
  PositionRange range_;
  PositionRange at_switches_;        // the part of it that limit switches have left
  std::uint32_t range_number_ = 0;   // of the bounds whose range is in it
  std::uint32_t active_limits_ = 0;  // limit switches, by terminal
  CommandBox command_;
  std::atomic<std::uint32_t> commanded_at_{0};  // the tick of the last command
  std::atomic<std::uint32_t> command_timeout_{0};
  std::atomic<bool> command_lost_{false};
  DigitalInputs inputs_;
  PositionReference position_;
  PositionLatch latch_;
  DirectionCheck check_;
  std::uint32_t history_from_ = 0;                // the tick in which the reference began anew
  std::atomic<std::uint32_t> outputs_driven_{0};  // levels while the brake is released, and while it is not
  std::atomic<std::uint32_t> outputs_off_{0};
  std::atomic<std::uint32_t> events_{0};  // a fault, and kRefused
  CyclicPosition cyclic_position_;
  ReferenceGenerator reference_;
  ParameterSwap<ControlSet> sets_;
  PointToPoint point_to_point_;
  std::array<ReferencePoint, kDelayed> delay_{};
  // From the tick to the main loop, beside the points of delay_.
  struct Residual {
    float dry_N = 0.0F;
    float residual_N = std::numeric_limits<float>::quiet_NaN();  // none: it says nothing about the level
  };
  std::array<Residual, kDelayed> residuals_{};
  UserBounds user_bounds_;   // as the main loop gave them last
  std::uint32_t faded_ = 0;  // the tick of the last fade_position()
  HysteresisMemory memory_;
  UpTime up_time_;
  float time_s_ = 0.0F;           // since the start, as of the last poll()
  std::uint32_t remembered_ = 0;  // the tick whose point memory_ has seen last
  std::uint32_t memory_number_ = 0;
  int memory_shift_ = kNoShift;
  ThermalLimit thermal_;
  std::uint32_t load_tick_ = 0;
  bool was_spent_ = false;
};

}  // namespace slipstack
