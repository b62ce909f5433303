// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/connection_supervision/command_supervision.h"
#include "firmware/canopen/profile/bounds_profile.h"
#include "firmware/canopen/profile/cyclic_profile.h"
#include "firmware/canopen/profile/homing_profile.h"
#include "firmware/canopen/profile/position_profile.h"
#include "firmware/canopen/profile/profile_checks.h"
#include "firmware/canopen/profile/profile_context.h"
#include "firmware/canopen/profile/profile_values.h"
#include "firmware/canopen/profile/stop_options.h"
#include "firmware/canopen/profile/touch_probe_profile.h"
#include "firmware/canopen/profile/velocity_profile.h"

namespace slipstack::canopen {

/// The drive profile CiA 402 (IEC 61800-7-201): control word and status word, and the mode of operation that
/// they belong to. Bound to the controller; in the main loop.
class DriveProfile {
 public:
  explicit DriveProfile(Controller& controller, EdgeCapture* edges = nullptr)
      : controller_(controller), context_(controller), supervision_(controller), probes_(context_, edges) {}

  /// The dictionary holds other values, after a start or a reset: the axis is stopped, and until end_reset()
  /// no controlword is followed.
  void begin_reset(Dictionary& dictionary) {
    context_.dictionary = &dictionary;
    take_units();
    resetting_ = true;
    probes_.reset();
    context_.control = 0;
    mode_ = Mode::kNone;
    command();
  }
  void end_reset() {
    resetting_ = false;
    command();
  }

  /// Once in every poll.
  void step() {
    follow_supervision();
    probes_.step();
    follow_mode();
    cyclic_.follow();
    follow_bounds();
    command();
    if (context_.mode == Mode::kProfilePosition) position_.step();
    if (context_.mode == Mode::kProfileVelocity) velocity_.step();
    if (context_.mode == Mode::kHoming) homing_.step(*context_.dictionary, context_.operation_enabled());
  }

  bool driving() const { return controller_.driving(); }
  void set_operational(bool operational) { operational_ = operational; }

  /// 6007h: what follows when the master is lost.
  void connection_lost() {
    if (!driving()) return;
    if (CommandSupervision::is_fault(*context_.dictionary)) controller_.inject(Fault::kConnection);
    context_.control =
        static_cast<std::uint16_t>(context_.control & ~CommandSupervision::reaction(*context_.dictionary));
    command();
  }

  /// Nobody hears the node. A target velocity holds until another one comes: nothing else would end the
  /// motion.
  void unheard() {
    if (context_.mode == Mode::kProfileVelocity && velocity_.moves()) connection_lost();
  }

  /// 603Fh: the fault, or that commands fail to come (8100h: communication).
  std::uint16_t error_code() const {
    const Fault fault = controller_.state().faults().latched();
    return fault == Fault::kNone && supervision_.lost() ? 0x8100 : slipstack::error_code(fault);
  }

  /// The set-point that SYNC makes something of.
  std::size_t set_point_row() const {
    return context_.mode == Mode::kCyclicVelocity ? kRow<0x60FF> : kRow<0x607A>;
  }
  /// SYNC. `with_sync`: a PDO brought this set-point just now.
  void synchronise(bool with_sync) { cyclic_.synchronise(with_sync); }

  // ---- objects ----

  std::uint32_t read(std::uint16_t index, std::size_t row) const {
    if (TouchProbeProfile::has(index)) return probes_.read(index);
    switch (index) {
      case 0x603F:
        return error_code();
      case 0x6041:
        return statusword();
      default:
        return profile_value(context_, index, row);
    }
  }

  Abort check(std::size_t row, std::uint32_t value) const {
    return check_profile_object(context_, row, value);
  }

  void written(std::uint16_t index, std::uint32_t value_now) {
    received(index);
    switch (index) {
      case 0x6040:
        return controlword(static_cast<std::uint16_t>(value_now));
      case 0x6060:
        mode_ = static_cast<Mode>(static_cast<std::int8_t>(value_now));
        return follow_mode();
      case 0x607A:
        if (context_.mode != Mode::kCyclicVelocity) cyclic_.target_written();
        return;
      case 0x60B1:
      case 0x60FF:
        return velocity_written(index, value_now);
      case 0x60B8:
        return probes_.command(value_now);
      case 0x607E:
      case 0x608F:
      case 0x6091:
      case 0x6092:
        return take_units();
      case 0x607D:
      case 0x607F:
      case 0x6080:
      case 0x6084:
      case 0x6085:
      case 0x60A4:
      case 0x60C5:
      case 0x60C6:
      case kBrakeIndex:
        return bounds_.changed();
      default:
        return;
    }
  }

  /// All that came together was written: control word, mode and forces reach the tick at once.
  void commit() {
    follow_bounds();
    command();
  }

 private:
  // A command of the master: controlword, mode, or set-point. A loss that the main loop has not seen yet
  // takes effect first, so that a command that comes late does not undo it.
  void received(std::uint16_t index) {
    const bool offset = index >= 0x60B0 && index <= 0x60B2;
    const bool velocity = index == 0x60FF && context_.mode == Mode::kCyclicVelocity;
    const bool set_point = index == 0x607A || index == 0x6071 || velocity;
    if (!set_point && !offset && index != 0x6040 && index != 0x6060 && index != 0x60FF) return;
    follow_supervision();
    supervision_.received(*context_.dictionary, set_point && context_.operation_enabled());
    loss_seen_ = false;
  }
  // Commands fail to come. The tick stops the axis by itself: where that is over before the main loop looks,
  // nothing is driven any more, and the loss is to be a fault all the same. Once for each loss, so that a
  // reset of the fault holds.
  void follow_supervision() {
    if (!supervision_.lost()) return;
    const bool missed = !loss_seen_ && !driving();
    loss_seen_ = true;
    if (missed && CommandSupervision::is_fault(*context_.dictionary)) controller_.inject(Fault::kConnection);
    connection_lost();
  }

  // Bits of IEC 61800-7-201 table 29; 12 and 13 by mode. 15, of the manufacturer: the position is referenced.
  std::uint16_t statusword() const {
    const DriveState state = controller_.state().state();
    unsigned word_now = status_word(state);
    const bool voltage = controller_.parameters().valid && !controller_.analogue().bus_low();
    if (voltage && controller_.inputs().amplifier_ready(controller_.parameters().io)) word_now |= 1U << 4;
    if (controller_.analogue().warns() || controller_.hunting().warning() != HuntingCause::kNone)
      word_now |= 1U << 7;
    if (state == DriveState::kSwitchOnDisabled || state == DriveState::kFault ||
        state == DriveState::kFaultReactionActive || state == DriveState::kNotReadyToSwitchOn) {
      word_now |= (context_.control & kQuickStop) != 0 ? 1U << 5 : 0U;
    }
    if (operational_) word_now |= 1U << 9;
    if (controller_.output().limits != 0 || position_.target_limited() || velocity_.target_limited() ||
        controller_.thermal().reduces())
      word_now |= 1U << 11;
    word_now |= status_of_mode(state);
    if (controller_.state().faults().latched() == Fault::kFollowingError) word_now |= 1U << 13;
    if (controller_.position().referenced()) word_now |= 1U << 15;
    return static_cast<std::uint16_t>(word_now);
  }

  // Bits 10 to 13.
  unsigned status_of_mode(DriveState state) const {
    switch (context_.mode) {
      case Mode::kNone:
        return 0;
      case Mode::kProfilePosition:
        return position_.status();
      case Mode::kProfileVelocity:
        return velocity_.status();
      case Mode::kHoming:
        return homing_.status();
      case Mode::kCyclicPosition:
      case Mode::kCyclicVelocity:
        return cyclic_.status();
      default:
        return state == DriveState::kOperationEnabled && !context_.halted() ? 1U << 12 : 0U;
    }
  }

  void controlword(std::uint16_t word_now) {
    if (resetting_) return;
    const auto changed = static_cast<std::uint16_t>(word_now ^ context_.control);
    const auto rising = static_cast<std::uint16_t>(word_now & changed);
    context_.control = word_now;
    cyclic_.follow();
    if (context_.mode == Mode::kProfilePosition) {
      position_.controlword(changed, rising);
    } else if (context_.mode == Mode::kProfileVelocity) {
      velocity_.controlword(changed);
    } else if (context_.mode == Mode::kHoming) {
      homing_.controlword(*context_.dictionary, word_now, changed, context_.operation_enabled());
    } else if ((rising & ProfileContext::kHaltBit) != 0 && context_.operation_enabled()) {
      controller_.reference().stop();
    }
  }

  // Options 0: no braking, current off. Quick stop options 5 and 6: braked and held, the state kept. Halt
  // leaves torque mode: the axis brakes and holds its place.
  void command() {
    if (resetting_) {
      // A quick stop, or current off.
      return controller_.command(
          Command{.word = context_.value(kRow<0x605A>) != 0 ? std::uint32_t{kEnableVoltage} : 0U});
    }
    std::uint16_t word_now = context_.control;
    const bool quick_stop = (word_now & kQuickStop) == 0;
    if (quick_stop && context_.value(kRow<0x605A>) == 0)
      word_now &= static_cast<std::uint16_t>(~kEnableVoltage);
    std::uint32_t options = 0;
    if (context_.mode == Mode::kCyclicTorque && !context_.halted()) options |= kTorqueMode;
    options |= stop_options(*context_.dictionary) | supervision();
    controller_.set_outputs(context_.value(kRow<0x60FE, 1>) & context_.value(kRow<0x60FE, 2>));
    controller_.command(Command{options | word_now, force_N(kRow<0x6071>), force_N(kRow<0x60B2>)});
  }

  void follow_bounds() {
    if (!bounds_.step()) return;
    position_.bounds_changed();
    velocity_.bounds_changed();
  }

  // In the cyclic modes, from the first set-point on; a force that was there before counts as one. The
  // profile modes are not cyclic: what was commanded holds, and communication is supervised (1016h, 1029h).
  std::uint32_t supervision() const {
    const bool torque = context_.mode == Mode::kCyclicTorque;
    const bool streams =
        context_.mode == Mode::kCyclicPosition || context_.mode == Mode::kCyclicVelocity || torque;
    if (!context_.operation_enabled() || !streams) return 0;
    const bool forced = torque && (context_.value(kRow<0x6071>) != 0 || context_.value(kRow<0x60B2>) != 0);
    return supervision_.options(*context_.dictionary, cyclic_.target_holds() || forced);
  }

  // 6071h or 60B2h, in thousandths of the rated force. The target counts in torque mode only, the offset in
  // every mode.
  float force_N(std::size_t row) const {
    const float thousandths = static_cast<float>(static_cast<std::int32_t>(context_.value(row)));
    return thousandths * 1e-3F * rated_force_N(*context_.dictionary, context_.axis());
  }

  void follow_mode() {
    follow_enabling();
    if (mode_ == context_.mode) return;
    context_.mode = mode_;
    homing_.reset();
    supervision_.rest();
    cyclic_.follow();
    if (context_.operation_enabled()) controller_.reference().stop();
    position_.give_up();
    velocity_.begin();
  }
  void follow_enabling() {
    const bool enabled = context_.operation_enabled();
    if (!enabled) {
      position_.give_up();
      supervision_.rest();
    }
    if (enabled != enabled_) velocity_.begin();
    enabled_ = enabled;
  }

  // What follows from enabling or a halt comes first: the value is not one from before.
  void velocity_written(std::uint16_t index, std::uint32_t value_now) {
    follow_enabling();
    cyclic_.follow();
    if (index == 0x60FF) context_.dictionary->set(kRow<0x60FF>, value_now);
    if (context_.mode == Mode::kCyclicVelocity) cyclic_.target_written();
  }

  // A target from before would mean another place.
  void take_units() {
    context_.units = UserUnits::of(*context_.dictionary).value_or(UserUnits{});
    bounds_.changed();
    context_.dictionary->set(kRow<0x607A>, context_.position());
  }

  Controller& controller_;
  ProfileContext context_;
  CommandSupervision supervision_;
  BoundsProfile bounds_{context_};
  PositionProfile position_{context_};
  VelocityProfile velocity_{context_};
  CyclicProfile cyclic_{context_};
  HomingProfile homing_{controller_, context_.units};
  TouchProbeProfile probes_;
  Mode mode_ = Mode::kNone;  // 6060h
  bool enabled_ = false;
  bool operational_ = false;
  bool resetting_ = false;
  bool loss_seen_ = false;  // the loss of commands that there is now was followed
};

}  // namespace slipstack::canopen
