// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/bounds/travel_limits.h"
#include "firmware/control/capture/position_latch.h"
#include "firmware/control/control_output.h"
#include "firmware/control/current/load_watch.h"
#include "firmware/control/force/excitation.h"
#include "firmware/control/force/force_control.h"
#include "firmware/control/force/model_upkeep.h"
#include "firmware/control/parameters/parameter_sets.h"
#include "firmware/control/reference/point_to_point.h"
#include "firmware/control/streams/cyclic_position.h"
#include "firmware/control/supervision/analogue_watch.h"
#include "firmware/control/supervision/digital_io.h"
#include "firmware/control/supervision/encoder_bridge.h"
#include "firmware/control/supervision/output_terminals.h"
#include "firmware/control/supervision/supervisor.h"
#include "firmware/control/tick_history.h"

namespace slipstack {

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
///
/// step() is the tick; everything else is for outside it, where nothing else is said.
class Controller {
 public:
  /// Checks and prepares new parameters; they are in force from the next tick on, or a later one (call
  /// poll() from the main loop). Refused parameters change nothing, and stop an enabled axis.
  ParameterStatus configure(const AxisParameters& axis, const ModelParameters& model) {
    const ParameterStatus status = sets_.configure(axis, model, upkeep_.time_s());
    if (ParameterSets::refused(status)) supervisor_.faults().parameters_refused();
    return status;
  }
  /// While the axis is not driven: from the next tick on there are no parameters, and the axis cannot be
  /// enabled before configure(), which may then change resolution and tick too. False while another change
  /// is pending.
  bool withdraw_parameters() { return sets_.withdraw(); }
  bool change_pending() const { return sets_.change_pending(); }
  /// Bounds of motion beside those of the axis; in force from the next tick on.
  void bound(const UserBounds& user) { sets_.bound(user); }
  const UserBounds& user_bounds() const { return sets_.user_bounds(); }

  /// How many ticks poll() may be late without missing one.
  static constexpr std::uint32_t kLatest = TickHistory::kLatest;
  /// From the main loop, at least every kLatest ticks: what follows the ticks without haste.
  void poll() {
    sets_.poll();
    cyclic_position_.poll(ticks());
    upkeep_.step(sets_, history_, position_, out_.driving);
    if (!position_.check_index(parameters().axis.reference)) inject(Fault::kIndexOffPlace);
    // What excites the loop alternates too fast to move the axis.
    const bool free = out_.driving && !excitation_.takes_part() && supervisor_.moves_freely();
    if (unseen_.follow(
            parameters().unseen, history_, [this] { return ticks(); }, free))
      inject(Fault::kEncoderStands);
    if (load_.step(parameters(), ticks(), driving(), measured_A())) inject(Fault::kOverload);
  }

  /// From the main loop, in every pass of it: what the board's analogue inputs say.
  void sense(const AnalogueReadings& readings) {
    const auto elapsed_s = static_cast<float>(ticks() - sensed_at_) * parameters().axis.tick_s;
    sensed_at_ = ticks();
    const Fault fault =
        parameters().valid ? analogue_.step(parameters().axis, readings, elapsed_s, driving()) : Fault::kNone;
    supervisor_.faults().hold(fault);
  }

  /// The control word 6040h; the same with kTorqueMode and what follows it; control word and forces at once.
  void command(std::uint16_t control_word) { supervisor_.command().write_control_word(control_word); }
  void command_all(std::uint32_t word) { supervisor_.command().write_word(word); }
  void command(const Command& command) { supervisor_.command().write(command); }
  /// The force in torque mode, and the force that is added in every mode, N.
  void set_torque(float target_N, float offset_N) {
    command(Command{supervisor_.command().read().word, target_N, offset_N});
  }
  /// A command of the master came; those that supervision waits for are younger than `timeout_ticks`.
  void commanded(std::uint32_t timeout_ticks) { supervisor_.command().received(ticks(), timeout_ticks); }
  /// The time of supervised commands ran out, and none came since.
  bool command_lost() const { return supervisor_.command().lost(); }
  /// A fault found elsewhere, as a reset by the watchdog; seen by the next tick.
  void inject(Fault fault) { supervisor_.faults().inject(fault); }
  /// Again after a change of parameters: what 60FEh asks of the digital outputs.
  void set_outputs(std::uint32_t wanted) { outputs_.set(parameters().io, wanted); }

  /// Retargets the reference, within the limits of the axis, from whatever state it is in.
  PlanStatus move_to(std::int32_t counts) { return move_to(counts, bounds().motion); }
  /// The same within narrower limits; what is wider is not taken.
  PlanStatus move_to(std::int32_t counts, const MotionLimits& limits) {
    return point_to_point_.move(reference_, counts, limits.and_within(bounds().motion), ramp(), range(),
                                position_.origin());
  }
  /// Moves in this direction (1 or -1) until something else is commanded, 2^31 counts at the most.
  PlanStatus search(std::int32_t direction, const MotionLimits& limits) {
    return point_to_point_.search(reference_, direction, limits.and_within(bounds().motion), ramp());
  }
  /// Changes to this velocity, counts per tick, as far as the limits allow, and keeps it until something else
  /// is commanded or the end of the range comes.
  PlanStatus run(float velocity, const MotionLimits& limits) {
    return point_to_point_.run(reference_, velocity, limits.and_within(bounds().motion), ramp(), range());
  }
  /// To rest, within these limits.
  PlanStatus halt(const MotionLimits& limits) {
    return point_to_point_.halt(reference_, limits.and_within(bounds().motion), ramp());
  }

  /// The reference so many ticks from now, if nothing else is commanded. O(lead).
  Motion ahead(std::uint32_t lead) const { return reference_.predict(lead, ramp()).motion; }
  /// What moves are bounded by.
  const MotionLimits& motion_limits() const { return bounds().motion; }
  /// Of the quick stop, counts per tick^2.
  float stop_deceleration() const { return bounds().quick_stop.deceleration_counts; }
  /// What set-points of position are bounded by.
  MotionLimits stream_limits() const {
    const TrackingLimits& tracking = bounds().tracking;
    return {tracking.velocity, tracking.acceleration, tracking.acceleration, bounds().motion.jerk};
  }

  /// Excites the loop while the reference rests or moves at constant velocity; to begin, it must be possible.
  Excitation& excitation() { return excitation_; }
  const Excitation& excitation() const { return excitation_; }
  bool may_excite() const { return mode_ == ControlMode::kPosition && state().follows_commands(); }
  ReferenceGenerator& reference() { return reference_; }
  const ReferenceGenerator& reference() const { return reference_; }
  /// Where position zero lies in counts.
  PositionReference& position() { return position_; }
  const PositionReference& position() const { return position_; }
  /// Of homing.
  PositionLatch& latch() { return latch_; }
  CyclicPosition& cyclic_position() { return cyclic_position_; }
  const CyclicPosition& cyclic_position() const { return cyclic_position_; }

  /// In the tick, before its step: an index mark passed at these counts.
  void index_passed(std::int32_t counts) {
    latch_.index_passed(counts);
    history_.index_passed(counts);
    position_.index_passed(counts);
  }

  /// In the tick, before its step: the encoder has no position. An absolute one is bridged.
  [[gnu::noinline]] void bridge(EncoderReading& reading) {
    const PositionReferenceParameters& encoder = parameters().axis.reference;
    const FaultMonitor& monitor = supervisor_.faults().monitor();
    if (encoder.absolute_encoder)
      bridge_.step(reading, encoder.bridged_ticks, ticks(), monitor.last_counts(), monitor.last_step());
  }

  /// In the tick: limits of the travel, faults and commands, then the mode, its reference and its force.
  const ControlOutput& step(const TickInputs& in) {
    const bool new_parameters = sets_.begin_tick();
    ControlSet& set = sets_.active();
    const std::int32_t counts = in.encoder.counts;
    if (new_parameters) begin_with(set, counts);
    inputs_ = DigitalInputs(in.digital);
    entry_ = &history_.entry(sets_.tick());
    entry_->reading = {counts, in.digital, force_.last_A()};
    if (latch_.armed()) [[unlikely]]
      latch_.step(inputs_, set.io, counts);
    const MotionBounds& bounds = set.bounds.read();
    out_.limits = 0;
    travel_.step(set.io, bounds, inputs_, counts, reference_, cyclic_position_, out_.limits);
    supervise(set, bounds, in);
    const ControlMode before = mode_;
    change_mode(supervisor_.mode(mode_, reference_, out_.limits));
    const bool fade =
        new_parameters || (mode_ != before && before != ControlMode::kOff) || excitation_.left();
    bool finite = true;
    switch (mode_) {
      case ControlMode::kOff:
        stay_off(set, bounds, counts);
        break;
      case ControlMode::kPosition:
        finite = excitation_.takes_part() ? control_excited(set, bounds, counts)
                                          : control_position(set, bounds, counts, fade);
        break;
      case ControlMode::kTorque:
        finite = control_torque(set, bounds, counts, fade);
        break;
      case ControlMode::kPush:
        finite = push(set, bounds, counts, fade);
        break;
    }
    if (!finite) [[unlikely]]
      stop_not_finite(set);
    out_.driving = mode_ != ControlMode::kOff;
    return out_;
  }

  const ControlOutput& output() const { return out_; }
  /// Current flows: also before operation is enabled, in the check of the direction.
  bool driving() const { return out_.driving || state().driving(); }
  /// Temperature and voltage, as of the last sense().
  const AnalogueWatch& analogue() const { return analogue_; }
  /// I2t, as of the last poll().
  const ThermalLimit& thermal() const { return load_.thermal(); }
  /// The check of the direction is still to be passed.
  bool direction_unknown() const { return supervisor_.check().unknown(); }
  const FrictionModel<float>::Force& friction() const { return parameters().model.force(); }
  /// What the drift of the friction goes by: how long the axis has been running, or is taken to have been, s.
  float drift_s() const { return upkeep_.time_s() + parameters().drift_begin_s; }
  /// What the adaptation has added to the mass of the model, kg.
  float added_kg() const { return upkeep_.added_kg(); }
  /// As far as the last poll() has followed the tick.
  const HysteresisMemory& memory() const { return upkeep_.memory(); }
  const StateMachine& state() const { return supervisor_.state(); }
  const StateEstimate& estimate() const { return force_.estimate(); }
  /// Levels of the output terminals, the brake as the state has it; in the tick.
  std::uint32_t digital_outputs() const { return outputs_.levels(supervisor_.brake_released()); }
  /// Of the last tick; what they mean is in parameters().io.
  const DigitalInputs& inputs() const { return inputs_; }
  /// The last ticks, for what follows them outside the tick.
  const TickHistory& history() const { return history_; }
  /// The readings of the last tick.
  std::int32_t measured_counts() const { return supervisor_.faults().monitor().last_counts(); }
  float measured_A() const { return supervisor_.faults().monitor().last_A(); }
  /// Where the axis may be.
  PositionRange range() const { return travel_.range(bounds()); }
  const ControlSet& parameters() const { return sets_.active(); }
  std::uint32_t ticks() const { return sets_.tick(); }

 private:
  const MotionBounds& bounds() const { return parameters().bounds.read(); }

  const BrakingLimits& ramp() const { return supervisor_.ramp(bounds()); }

  // The first tick of new parameters.
  void begin_with(const ControlSet& set, std::int32_t counts) {
    load_.begin(set.axis.current_limit_A);
    const bool starts = set.valid && !started_;
    started_ = set.valid;
    supervisor_.begin_with(set, starts, counts);
    if (!starts) return;
    force_.start(set, counts);
    position_.start(set.axis.reference);
  }

  // The reference brakes from the next tick on where it has to begin anew, as in every stop out of a mode in
  // which it followed the axis.
  [[gnu::noinline]] void supervise(ControlSet& set, const MotionBounds& bounds, const TickInputs& in) {
    const std::int32_t counts = in.encoder.counts;
    if (!set.valid) set.start_counts = counts;
    const bool anew = supervisor_.step(set, bounds, in, inputs_, sets_.tick(), out_, force_.last_A(),
                                       position_, reference_);
    if (!anew && !(follows_axis(mode_) && state().braking())) return;
    history_.begin_anew(sets_.tick());
    const std::int32_t last_step = supervisor_.faults().monitor().last_step();
    reference_.follow(counts, force_.begin_anew(set, last_step));
  }

  // The reference lies where the axis is.
  static bool follows_axis(ControlMode mode) {
    return mode == ControlMode::kTorque || mode == ControlMode::kPush;
  }

  void change_mode(ControlMode mode) {
    if (mode == mode_) return;
    // Out of torque mode the axis is braked from its own velocity, then holds its position. In a stop the
    // supervisor does that.
    if (follows_axis(mode_) && mode == ControlMode::kPosition && !state().braking()) reference_.stop();
    force_.change_mode(mode == ControlMode::kOff);
    mode_ = mode;
  }

  // ---- the modes; false: the force is not finite ----

  // The reference lies where the axis is, so that the hysteresis follows.
  void stay_off(ControlSet& set, const MotionBounds& bounds, std::int32_t counts) {
    reference_.hold(counts);
    if (excitation_.takes_part()) [[unlikely]]
      excitation_.leave();
    step_model(set, bounds, counts);
    force_.step_off(tick(set, bounds, counts, false));
  }
  [[gnu::always_inline]] bool control_position(ControlSet& set, const MotionBounds& bounds,
                                               std::int32_t counts, bool fade) {
    step_model(set, bounds, counts);
    return force_.step_position(tick(set, bounds, counts, fade));
  }
  // The force of the model stays what it was: the reference stands, or moves at constant velocity, and
  // without the model the tick is no longer than any other. What it misses fades in when the model is back.
  [[gnu::noinline]] bool control_excited(ControlSet& set, const MotionBounds& bounds, std::int32_t counts) {
    const bool ends = reference_.braking() || reference_.plan_waits() || !excitation_.running();
    if (ends) excitation_.leave();
    entry_->point = reference_.next(supervisor_.ramp(bounds));
    entry_->residual = force_.note();
    return force_.step_excited(tick(set, bounds, counts, ends), excitation_);
  }
  bool control_torque(ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade) {
    if (excitation_.takes_part()) [[unlikely]]
      excitation_.leave();
    follow_axis(set, counts);
    step_model(set, bounds, counts);
    return force_.step_torque(tick(set, bounds, counts, fade), supervisor_.torque_bounds(), travel_.range());
  }
  [[gnu::noinline]] bool push(ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade) {
    follow_axis(set, counts);
    step_model(set, bounds, counts);
    return force_.step_push(tick(set, bounds, counts, fade), supervisor_.check().force_N());
  }

  // The reference lies where the axis is and moves as it does.
  void follow_axis(const ControlSet& set, std::int32_t counts) {
    reference_.follow(counts, force_.estimate().velocity_mps() * set.counts_per_mps);
  }
  // The next point of the reference, and the force of the model there.
  void step_model(ControlSet& set, const MotionBounds& bounds, std::int32_t counts) {
    const std::uint32_t tick = sets_.tick();
    // The first tick with current holds the axis where it is.
    const bool streamed = out_.driving && mode_ == ControlMode::kPosition && !state().braking();
    TickHistory::Entry& entry = *entry_;
    if (streamed && cyclic_position_.step(tick)) {
      entry.point = reference_.track(cyclic_position_.point(), bounds.tracking);
    } else {
      entry.point = reference_.next(supervisor_.ramp(bounds));
    }
    out_.level = upkeep_.level();
    force_.observe(set, entry.point, counts, mode_ != ControlMode::kPosition);
    out_.feedforward_N = force_.step_model(set, entry.point, out_.level, position_);
    entry.residual = force_.note();
  }
  ForceControl::Tick tick(const ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade) {
    return {set,
            bounds,
            supervisor_.command().read(),
            history_,
            *entry_,
            out_,
            sets_.tick(),
            counts,
            load_.largest_A(),
            reference_.braking(),
            fade};
  }

  // No current. What the value may have reached is reset: here, and by the change of mode.
  void stop_not_finite(ControlSet& set) {
    supervisor_.raise(Fault::kNotFinite);
    change_mode(ControlMode::kOff);
    out_.current_A = 0.0F;
    force_.forget(set);
  }

  // What the tick uses most comes first: a single load instruction reaches it (1020 bytes, Armv7E-M VLDR).
  Supervisor supervisor_;
  ControlOutput out_;
  ControlMode mode_ = ControlMode::kOff;
  TickHistory::Entry* entry_ = nullptr;  // of this tick: its place is found once
  bool started_ = false;
  TravelLimits travel_;
  DigitalInputs inputs_;
  PositionReference position_;
  PositionLatch latch_;
  OutputTerminals outputs_;
  LoadWatch load_;
  ForceControl force_;
  CyclicPosition cyclic_position_;
  Excitation excitation_;
  ReferenceGenerator reference_;
  ParameterSets sets_;
  ModelUpkeep upkeep_;
  PointToPoint point_to_point_;
  EncoderBridge bridge_;
  UnseenMotion unseen_;
  AnalogueWatch analogue_;
  std::uint32_t sensed_at_ = 0;
  TickHistory history_;
};

}  // namespace slipstack
