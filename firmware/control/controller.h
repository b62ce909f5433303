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
#include "firmware/control/hunting/hunting_watch.h"
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
/// In torque mode F = target + offset + a share (2000h:25) of the model's force. The reference then follows
/// the axis, and with it the hysteresis; a stop begins at the axis's own velocity. A change between the two
/// modes fades as one of parameters does.
///
/// step() is the tick; everything else is for outside it, where nothing else is said.
class Controller {
 public:
  Controller();

  /// Checks and prepares new parameters; they are in force from the next tick on, or a later one (call
  /// poll() from the main loop). Refused parameters change nothing, and stop an enabled axis.
  ParameterStatus configure(const AxisParameters& axis, const ModelParameters& model);
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
  void poll();

  /// From the main loop, in every pass of it: what the board's analogue inputs say.
  void sense(const AnalogueReadings& readings);

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
  PlanStatus move_to(std::int32_t counts, const MotionLimits& limits);
  /// Moves in this direction (1 or -1) until something else is commanded, 2^31 counts at the most.
  PlanStatus search(std::int32_t direction, const MotionLimits& limits);
  /// Changes to this velocity, counts per tick, as far as the limits allow, and keeps it until something else
  /// is commanded or the end of the range comes.
  PlanStatus run(float velocity, const MotionLimits& limits);
  /// To rest, within these limits.
  PlanStatus halt(const MotionLimits& limits);

  /// The reference so many ticks from now, if nothing else is commanded. O(lead).
  Motion ahead(std::uint32_t lead) const;
  /// What moves are bounded by.
  const MotionLimits& motion_limits() const { return bounds().motion; }
  /// Of the quick stop, counts per tick^2.
  float stop_deceleration() const { return bounds().quick_stop.deceleration_counts; }
  /// What set-points of position are bounded by.
  MotionLimits stream_limits() const { return bounds().of_stream(parameters().axis); }

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
  void bridge(EncoderReading& reading);

  /// In the tick: limits of the travel, faults and commands, then the mode, its reference and its force.
  const ControlOutput& step(const TickInputs& in);

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
  /// Whether the axis hunts, as far as the last poll() has followed the tick.
  const HuntingWatch& hunting() const { return hunting_; }
  /// What was found of it no longer holds: full compensation.
  void forget_hunting() { hunting_.forget(); }
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
  void begin_with(const ControlSet& set, std::int32_t counts);

  // The reference brakes from the next tick on where it has to begin anew, as in every stop out of a mode in
  // which it followed the axis.
  void supervise(ControlSet& set, const MotionBounds& bounds, const TickInputs& in);

  // The reference lies where the axis is.
  static bool follows_axis(ControlMode mode) {
    return mode == ControlMode::kTorque || mode == ControlMode::kPush;
  }

  void change_mode(ControlMode mode);

  // In poll(): the current may move the axis. What excites the loop alternates too fast for that.
  bool moves_freely() const {
    return out_.driving && !excitation_.takes_part() && supervisor_.moves_freely();
  }

  // In poll(): what hunts is compensated less.
  void watch_hunting();

  // ---- the modes; false: the force is not finite ----

  // The reference lies where the axis is, so that the hysteresis follows.
  void stay_off(ControlSet& set, const MotionBounds& bounds, std::int32_t counts);
  bool control_position(ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade);
  // The force of the model stays what it was: the reference stands, or moves at constant velocity, and
  // without the model the tick is no longer than any other. What it misses fades in when the model is back.
  bool control_excited(ControlSet& set, const MotionBounds& bounds, std::int32_t counts);
  bool control_torque(ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade);
  bool push(ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade);

  // The reference lies where the axis is and moves as it does.
  void follow_axis(const ControlSet& set, std::int32_t counts);
  // The next point of the reference, and the force of the model there.
  void step_model(ControlSet& set, const MotionBounds& bounds, std::int32_t counts);
  ForceControl::Tick tick(const ControlSet& set, const MotionBounds& bounds, std::int32_t counts, bool fade);

  // No current. What the value may have reached is reset: here, and by the change of mode.
  void stop_not_finite(ControlSet& set);

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
  PointToPoint point_to_point_;
  EncoderBridge bridge_;
  UnseenMotion unseen_;
  AnalogueWatch analogue_;
  std::uint32_t sensed_at_ = 0;
  TickHistory history_;
  ModelUpkeep upkeep_;  // behind what the tick reaches with one instruction, as the next one
  HuntingWatch hunting_;
};

}  // namespace slipstack
