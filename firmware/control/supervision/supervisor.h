// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/bounds/motion_bounds.h"
#include "firmware/control/bounds/torque_bounds.h"
#include "firmware/control/control_output.h"
#include "firmware/control/homing/position_reference.h"
#include "firmware/control/reference/reference.h"
#include "firmware/control/supervision/direction_check.h"
#include "firmware/control/supervision/fault_sources.h"
#include "firmware/control/supervision/state_machine.h"
#include "firmware/control/supervision/supervised_command.h"

namespace slipstack {

/// Whether and how the axis may be driven: command, faults and direction check lead the state machine, and
/// where its new state asks for a stop the reference brakes.
class Supervisor {
 public:
  /// In the tick. `last`: what the controller published the tick before, with `last_A`. True once when the
  /// reference must begin anew where the axis is, because it is away from there.
  bool step(const ControlSet& set, const MotionBounds& bounds, const TickInputs& in,
            const DigitalInputs& digital, std::uint32_t tick, const ControlOutput& last, float last_A,
            PositionReference& place, ReferenceGenerator& reference) {
    Fault fault = faults_.check(set, in, digital, last.reference_counts, last_A, last.driving);
    std::uint32_t command = command_.word(tick);
    if (check_.pending()) [[unlikely]] {
      fault = check_.before_enabling(set.direction, bounds.times.brake_release, in.encoder.counts,
                                     state_.state(), command, fault);
    }
    if (fault != Fault::kNone) [[unlikely]]
      note(fault, set, place);
    state_.step(
        command, fault, set.valid, [&reference] { return reference.standing(); }, bounds.times);
    if (!state_.braking()) return false;
    if (state_.takes_axis_over()) return true;
    if (!reference.braking() && !reference.standing()) reference.stop();
    return false;
  }

  /// What the tick does with the motor from now on. `now`: what it did before; `standing`: the reference
  /// rests. Adds to `limits` that an end of the travel holds the axis in torque mode.
  ControlMode mode(ControlMode now, const ReferenceGenerator& reference, std::uint16_t& limits) {
    const bool torque = state_.torque_mode();
    if (!torque) torque_bounds_.release();
    if (!state_.driving()) return check_.pushing() ? ControlMode::kPush : ControlMode::kOff;
    if (!torque) return ControlMode::kPosition;
    if (!torque_bounds_.holds()) return ControlMode::kTorque;
    const Command& command = command_.read();
    if (now == ControlMode::kPosition && reference.standing() &&
        torque_bounds_.pulled_inwards(command.target_N + command.offset_N)) {
      torque_bounds_.release();
      return ControlMode::kTorque;
    }
    limits |= kLimitPosition;
    return ControlMode::kPosition;
  }

  /// In the first tick of new parameters. `starts`: there were none.
  void begin_with(const ControlSet& set, bool starts, std::int32_t counts) {
    check_.begin(set.direction);
    if (starts) faults_.reset(counts);
  }

  /// In the tick: a fault that its own force has.
  void raise(Fault fault) { state_.raise(fault); }

  /// Of a stop that is under way, or would begin now.
  const BrakingLimits& ramp(const MotionBounds& bounds) const {
    return state_.slows_down() ? bounds.slow_down : bounds.quick_stop;
  }
  /// The brake is to be open.
  bool brake_released() const { return state_.brake_released() || check_.pushing(); }

  TorqueBounds& torque_bounds() { return torque_bounds_; }
  SupervisedCommand& command() { return command_; }
  const SupervisedCommand& command() const { return command_; }
  FaultSources& faults() { return faults_; }
  const FaultSources& faults() const { return faults_; }
  /// The current may move the axis.
  bool moves_freely() const { return state_.unbraked() || check_.pushing(); }
  const StateMachine& state() const { return state_; }
  const DirectionCheck& check() const { return check_; }

 private:
  // An absolute encoder that works again knows its place; an incremental one has to be homed.
  [[gnu::noinline]] void note(Fault fault, const ControlSet& set, PositionReference& place) {
    if (loses_place(fault) && !set.axis.reference.absolute_encoder) place.lose();
    if (doubts_direction(fault)) check_.doubt(set.direction);
  }

  StateMachine state_;
  FaultSources faults_;
  SupervisedCommand command_;
  DirectionCheck check_;
  TorqueBounds torque_bounds_;
};

}  // namespace slipstack
