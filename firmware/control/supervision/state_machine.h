// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/supervision/faults.h"
#include "firmware/control/supervision/holding_brake.h"

namespace slipstack {

/// States of the power drive system (IEC 61800-7-201, CiA 402: figure 2). Not ready is left by itself.
enum class DriveState : std::uint8_t {
  kNotReadyToSwitchOn,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReactionActive,
  kFault,
};

/// Bits of the control word 6040h.
enum ControlBit : std::uint16_t {
  kSwitchOn = 1U << 0,
  kEnableVoltage = 1U << 1,
  kQuickStop = 1U << 2,  ///< 0 asks for it
  kEnableOperation = 1U << 3,
  kFaultReset = 1U << 7,  ///< rising edge
  kHalt = 1U << 8,
};

/// What the tick is asked for beyond the control word, in the same word.
inline constexpr std::uint32_t kTorqueMode = 1U << 16;      ///< the force is given; 0: the position
inline constexpr std::uint32_t kReleaseOnFault = 1U << 17;  ///< no controlled stop after a fault (605Eh: 0)
inline constexpr std::uint32_t kStayStopped = 1U << 18;  ///< quick stop ends holding the axis (605Ah: 5, 6)
/// Bits of the control word that the tick clears when commands fail to come, shifted: the reaction of 6007h.
/// None: commands are not supervised.
inline constexpr std::uint32_t kReactionShift = 18;
inline constexpr std::uint32_t kLostDisables = kEnableVoltage << kReactionShift;
inline constexpr std::uint32_t kLostStops = kQuickStop << kReactionShift;
inline constexpr std::uint32_t kBrakeOnShutdown = 1U << 21;  ///< before transition 8 (605Bh: 1)
inline constexpr std::uint32_t kBrakeOnDisable = 1U << 22;   ///< before transition 5 (605Ch: 1)
/// Stops along the slow down ramp instead of the quick stop ramp.
inline constexpr std::uint32_t kSlowQuickStop = 1U << 23;      ///< 605Ah: 1, 5
inline constexpr std::uint32_t kSlowFaultReaction = 1U << 24;  ///< 605Eh: 1
inline constexpr std::uint32_t kSlowHalt = 1U << 25;           ///< 605Dh: 1

/// Times of enabling and stopping, ticks.
struct StopTimes {
  std::int32_t quick_stop = 0;     ///< longest stop along the quick stop ramp
  std::int32_t slow_down = 0;      ///< along the slow down ramp
  std::int32_t brake_release = 0;  ///< from current on until the brake is open
  std::int32_t brake_apply = 0;    ///< from standstill until it is closed
};

/// The state's bits of the status word 6041h.
constexpr std::uint16_t status_word(DriveState state) {
  constexpr std::uint16_t kWords[] = {0x0000, 0x0040, 0x0021, 0x0023, 0x0027, 0x0007, 0x000F, 0x0008};
  return kWords[static_cast<std::size_t>(state)];
}

/// Follows the control word and the faults.
///
/// Every stop is the same: while braking() the reference is brought to rest along one of two ramps, the brake
/// is applied, and when it is closed the state is left for the one that the cause of the stop leads to. What
/// cannot be braked takes the last step at once.
class StateMachine {
 public:
  DriveState state() const { return state_; }
  /// Current flows.
  bool driving() const { return driving_; }
  /// The axis is being stopped under control, or held after that.
  bool braking() const { return stopping_; }
  /// Operation is enabled, and no command has ended it: the axis may be moved.
  bool follows_commands() const { return state_ == DriveState::kOperationEnabled && !stopping_; }
  /// The brake is to be open. Without a brake nothing depends on it.
  bool brake_released() const { return driving() && brake_.is_open(); }
  /// The current may move the axis: a brake is open by now.
  bool unbraked() const { return driving_ && brake_.is_open() && !brake_.opening(); }
  const FaultRecord& faults() const { return faults_; }

  /// The force is given, not the position.
  bool torque_mode() const { return follows_commands() && (last_command_ & kTorqueMode) != 0; }

  /// Stops go along the slow down ramp: that under way, or a halt.
  bool slows_down() const {
    return stopping_ ? slow_stop_ : (last_command_ & (kSlowHalt | kHalt)) == (kSlowHalt | kHalt);
  }

  /// Once after a fault that the axis does not follow its reference with: it is to be braked as it moves.
  bool takes_axis_over() {
    const bool now = anew_;
    anew_ = false;
    return now;
  }

  /// One tick. `command`: ControlBit and the options above. `ready`: parameters are there. `standing()`: the
  /// reference is at rest; asked while stopping only.
  template <class Standing>
  [[gnu::always_inline]] void step(std::uint32_t command, Fault fault, bool ready, Standing&& standing,
                                   const StopTimes& times) {
    const std::uint32_t rising = command & ~last_command_;
    last_command_ = command;
    if (fault != Fault::kNone && raise(fault)) return;
    // What nearly every tick of a moving axis finds.
    if (state_ == DriveState::kOperationEnabled && !stopping_ && !brake_.opening() && ready &&
        (command & kEnable) == kEnable) {
      return;
    }
    if (state_ == DriveState::kQuickStopActive && leaves_quick_stop(command)) {
      leave_for(state_);  // transition 12 or 16
    } else if (stopping_ && !more_urgent(command)) {
      stop(standing(), times);
    } else if (state_ == DriveState::kFault) {
      if ((rising & kFaultReset) != 0 && fault == Fault::kNone) {
        faults_.reset();
        state_ = DriveState::kSwitchOnDisabled;
      }
    } else if (state_ == DriveState::kNotReadyToSwitchOn) {
      if (ready) state_ = DriveState::kSwitchOnDisabled;
    } else {
      follow(command, ready, times);
    }
    note_driving();
  }

  /// A fault: latched and counted; the axis released at once, or stopped under control. True when it changes
  /// the state, which then is that of this tick.
  bool raise(Fault fault) {
    const bool reacting = state_ == DriveState::kFaultReactionActive;
    const bool again = (reacting || state_ == DriveState::kFault) && faults_.has(fault);
    if (!again) faults_.note(fault);
    const FaultReaction reaction = reaction_to(fault);
    const bool released = reaction == FaultReaction::kRelease || (last_command_ & kReleaseOnFault) != 0 ||
                          (reacting && reaction == FaultReaction::kBrakeAnew);
    if (!driving() || released) {
      const bool new_state = state_ != DriveState::kFault;
      leave_for(DriveState::kFault);
      driving_ = false;
      return new_state;
    }
    if (reacting) return false;
    begin_stop(DriveState::kFaultReactionActive, DriveState::kFault, kSlowFaultReaction);
    anew_ = reaction == FaultReaction::kBrakeAnew;
    driving_ = true;
    return true;
  }

 private:
  static constexpr std::uint32_t kEnable = kSwitchOn | kEnableVoltage | kQuickStop | kEnableOperation;

  void note_driving() { driving_ = state_ == DriveState::kOperationEnabled || brake_.opening() || stopping_; }

  // Along the slow down ramp if the command has `slow`.
  void begin_stop(DriveState now, DriveState then, std::uint32_t slow) {
    slow_stop_ = (last_command_ & slow) != 0;
    state_ = now;
    after_stop_ = then;
    stopping_ = true;
    stopping_ticks_ = 0;
    brake_.rest();
  }
  void leave_for(DriveState state) {
    state_ = state;
    stopping_ = false;
    brake_.rest();
  }

  // By command: transition 12 (disable voltage), and 16 (enable operation) where the option lets the axis
  // stay.
  bool leaves_quick_stop(std::uint32_t control) {
    if ((control & kEnableVoltage) == 0) {
      state_ = DriveState::kSwitchOnDisabled;
    } else if ((control & (kEnable | kFaultReset | kStayStopped)) == (kEnable | kStayStopped)) {
      state_ = DriveState::kOperationEnabled;
    }
    return state_ != DriveState::kQuickStopActive;
  }

  // While operation is being disabled, along the ramp: disable voltage and quick stop do not wait for it.
  bool more_urgent(std::uint32_t control) {
    if (state_ != DriveState::kOperationEnabled) return false;
    constexpr std::uint32_t kOn = kEnableVoltage | kQuickStop;
    if ((control & kOn) == kOn) return false;
    stopping_ = false;
    return true;
  }

  void stop(bool standing, const StopTimes& times) {
    if (standing && stopping_ticks_ > 0) {
      const bool stays = state_ == DriveState::kQuickStopActive && (last_command_ & kStayStopped) != 0;
      if (!stays && brake_.close(times.brake_apply)) leave_for(after_stop_);
    } else if (++stopping_ticks_ > (slows_down() ? times.slow_down : times.quick_stop)) {
      faults_.note(Fault::kStopTimeout);
      leave_for(DriveState::kFault);
    }
  }

  // Transitions 2 to 11 by the commands of table 4: shutdown, switch on, enable operation and their reverse.
  // Those commands have bit 7 clear. With it set, nothing brings the axis nearer to moving; what takes
  // current away is followed all the same. So is the loss of the parameters.
  void follow(std::uint32_t control, bool ready, const StopTimes& times) {
    if (!ready || (control & kEnableVoltage) == 0) return leave_for(DriveState::kSwitchOnDisabled);
    if ((control & kQuickStop) == 0) {
      if (state_ != DriveState::kOperationEnabled) return leave_for(DriveState::kSwitchOnDisabled);
      return begin_stop(DriveState::kQuickStopActive, DriveState::kSwitchOnDisabled, kSlowQuickStop);
    }
    const bool switch_on = (control & kSwitchOn) != 0;
    const bool enable = (control & kEnableOperation) != 0;
    const bool up = (control & kFaultReset) == 0;
    switch (state_) {
      case DriveState::kSwitchOnDisabled:
        if (up && !switch_on) state_ = DriveState::kReadyToSwitchOn;
        break;
      case DriveState::kReadyToSwitchOn:
        if (up && switch_on) state_ = DriveState::kSwitchedOn;
        break;
      case DriveState::kSwitchedOn:
        if (!switch_on) {
          leave_for(DriveState::kReadyToSwitchOn);
        } else if (enable && (up || brake_.opening())) {
          // Transition 4: current on; operation is enabled when the brake is open.
          if (brake_.open(times.brake_release)) state_ = DriveState::kOperationEnabled;
        } else {
          brake_.stop_opening();
        }
        break;
      case DriveState::kOperationEnabled:
        if (!switch_on) {
          disable((control & kBrakeOnShutdown) != 0, DriveState::kReadyToSwitchOn);
        } else if (!enable) {
          disable((control & kBrakeOnDisable) != 0, DriveState::kSwitchedOn);
        }
        break;
      default:
        break;
    }
  }

  // Transitions 5 and 8, after the stop if the option has one.
  void disable(bool braked, DriveState then) {
    if (!braked) return leave_for(then);
    begin_stop(DriveState::kOperationEnabled, then, kBrakeOnShutdown | kBrakeOnDisable);
  }

  DriveState state_ = DriveState::kNotReadyToSwitchOn;
  DriveState after_stop_ = DriveState::kFault;
  bool stopping_ = false;
  bool anew_ = false;
  bool slow_stop_ = false;
  bool driving_ = false;
  std::uint32_t last_command_ = 0;
  std::int32_t stopping_ticks_ = 0;
  HoldingBrake brake_;
  FaultRecord faults_;
};

}  // namespace slipstack
