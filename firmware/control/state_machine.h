// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/faults.h"

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
};

/// What the tick is asked for beyond the control word, in the same word.
inline constexpr std::uint32_t kTorqueMode = 1U << 16;      ///< the force is given; 0: the position
inline constexpr std::uint32_t kReleaseOnFault = 1U << 17;  ///< no controlled stop after a fault (605Eh: 0)
inline constexpr std::uint32_t kStayStopped = 1U << 18;     ///< quick stop ends holding the axis (605Ah: 6)
/// Bits of the control word that the tick clears when commands fail to come, shifted: the reaction of 6007h.
/// None: commands are not supervised.
inline constexpr std::uint32_t kReactionShift = 18;
inline constexpr std::uint32_t kLostDisables = kEnableVoltage << kReactionShift;
inline constexpr std::uint32_t kLostStops = kQuickStop << kReactionShift;

/// The state's bits of the status word 6041h.
constexpr std::uint16_t status_word(DriveState state) {
  constexpr std::uint16_t kWords[] = {0x0000, 0x0040, 0x0021, 0x0023, 0x0027, 0x0007, 0x000F, 0x0008};
  return kWords[static_cast<std::size_t>(state)];
}

/// Follows the control word and the faults.
class StateMachine {
 public:
  DriveState state() const { return state_; }
  /// Current flows.
  bool driving() const { return state_ == DriveState::kOperationEnabled || braking(); }
  /// The axis is being stopped under control.
  bool braking() const {
    return state_ == DriveState::kQuickStopActive || state_ == DriveState::kFaultReactionActive;
  }
  const FaultRecord& faults() const { return faults_; }

  /// The force is given, not the position.
  bool torque_mode() const {
    return state_ == DriveState::kOperationEnabled && (last_command_ & kTorqueMode) != 0;
  }

  /// One tick. `command`: ControlBit, kTorqueMode, kReleaseOnFault, kStayStopped. `ready`: parameters are
  /// there. `standing`: the reference is at rest. `stop_timeout_ticks`: longest controlled stop.
  [[gnu::always_inline]] void step(std::uint32_t command, Fault fault, bool ready, bool standing,
                                   std::int32_t stop_timeout_ticks) {
    const std::uint32_t rising = command & ~last_command_;
    last_command_ = command;
    if (fault != Fault::kNone) raise(fault);
    // What nearly every tick of a moving axis finds.
    if (state_ == DriveState::kOperationEnabled && ready && (command & kEnable) == kEnable) return;
    if (state_ == DriveState::kQuickStopActive && leaves_quick_stop(command)) {
      // transition 12 or 16
    } else if (braking()) {
      stop(standing, stop_timeout_ticks);
    } else if (state_ == DriveState::kFault) {
      if ((rising & kFaultReset) != 0 && fault == Fault::kNone) {
        faults_.reset();
        state_ = DriveState::kSwitchOnDisabled;
      }
    } else if (state_ == DriveState::kNotReadyToSwitchOn) {
      if (ready) state_ = DriveState::kSwitchOnDisabled;
    } else {
      follow(command, ready);
    }
  }

  /// A fault: latched and counted; zero current at once, or a controlled stop.
  void raise(Fault fault) {
    const bool again = state_ == DriveState::kFault && faults_.latched() == fault;
    if (!again) faults_.note(fault);
    if (driving() && stops_under_control(fault) && (last_command_ & kReleaseOnFault) == 0) {
      if (state_ != DriveState::kFaultReactionActive) begin_stop(DriveState::kFaultReactionActive);
    } else {
      state_ = DriveState::kFault;
    }
  }

 private:
  static constexpr std::uint32_t kEnable = kSwitchOn | kEnableVoltage | kQuickStop | kEnableOperation;

  void begin_stop(DriveState state) {
    state_ = state;
    stopping_ticks_ = 0;
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

  void stop(bool standing, std::int32_t stop_timeout_ticks) {
    if (standing && stopping_ticks_ > 0) {
      if (state_ == DriveState::kFaultReactionActive) {
        state_ = DriveState::kFault;
      } else if ((last_command_ & kStayStopped) == 0) {
        state_ = DriveState::kSwitchOnDisabled;
      }
    } else if (++stopping_ticks_ > stop_timeout_ticks) {
      faults_.note(Fault::kStopTimeout);
      state_ = DriveState::kFault;
    }
  }

  // Transitions 2 to 11 by the commands of table 4: shutdown, switch on, enable operation and their reverse.
  // Those commands have bit 7 clear. With it set, nothing brings the axis nearer to moving; what takes
  // current away is followed all the same. So is the loss of the parameters.
  void follow(std::uint32_t control, bool ready) {
    if (!ready || (control & kEnableVoltage) == 0) {
      state_ = DriveState::kSwitchOnDisabled;
      return;
    }
    if ((control & kQuickStop) == 0) {
      if (state_ == DriveState::kOperationEnabled) {
        begin_stop(DriveState::kQuickStopActive);
      } else {
        state_ = DriveState::kSwitchOnDisabled;
      }
      return;
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
          state_ = DriveState::kReadyToSwitchOn;
        } else if (up && enable) {
          state_ = DriveState::kOperationEnabled;
        }
        break;
      case DriveState::kOperationEnabled:
        state_ = !switch_on ? DriveState::kReadyToSwitchOn : (enable ? state_ : DriveState::kSwitchedOn);
        break;
      default:
        break;
    }
  }

  DriveState state_ = DriveState::kNotReadyToSwitchOn;
  std::uint32_t last_command_ = 0;
  std::int32_t stopping_ticks_ = 0;
  FaultRecord faults_;
};

}  // namespace slipstack
