// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "firmware/canopen/dictionary.h"
#include "firmware/canopen/telemetry.h"
#include "firmware/control/controller.h"

namespace slipstack::canopen {

enum class Mode : std::int8_t { kNone = 0, kProfilePosition = 1, kCyclicPosition = 8, kCyclicTorque = 10 };

/// The drive profile CiA 402 (IEC 61800-7-201): control word and status word, modes of operation, set-points,
/// and the option codes of stops. Bound to the controller; in the main loop.
class DriveProfile {
 public:
  explicit DriveProfile(Controller& controller) : controller_(controller) {}

  /// The dictionary holds other values: after a start or a reset.
  void reset(Dictionary& dictionary) {
    dictionary_ = &dictionary;
    control_ = 0;
    mode_ = Mode::kNone;
    command();
  }

  /// Once in every poll.
  void step() {
    follow_mode();
    follow_cyclic();
    command();
    set_torque();
    profile_position();
  }

  bool driving() const { return controller_.state().driving(); }
  void set_operational(bool operational) { operational_ = operational; }

  /// 6007h: what follows when the master is lost.
  void connection_lost() {
    if (!driving()) return;
    switch (value(kRow<0x6007>)) {
      case 2:
        control_ = static_cast<std::uint16_t>(control_ & ~kEnableVoltage);
        break;
      case 3:
        control_ = static_cast<std::uint16_t>(control_ & ~kQuickStop);
        break;
      default:
        return;
    }
    command();
  }

  /// Cyclic position: SYNC makes a set-point of the target. One that a synchronous PDO brings must come with
  /// every SYNC; any other holds until it is written again. `with_sync`: a PDO brought it just now.
  void synchronise(bool with_sync) {
    follow_cyclic();
    const ControlSet& set = controller_.parameters();
    CyclicPosition& cyclic = controller_.cyclic_position();
    cyclic.set_period(period_s() / set.axis.tick_s, set.axis.tick_s,
                      set.axis.velocity_limit_mps / set.mps_per_count,
                      set.axis.acceleration_limit_mps2 / set.mps2_per_count);
    if (target_written_) target_streamed_ = with_sync;
    target_holds_ = target_holds_ || target_written_;
    const bool has_target = target_written_ || (target_holds_ && !target_streamed_);
    target_written_ = false;
    cyclic.sync(controller_.ticks(), has_target, static_cast<std::int32_t>(value(kRow<0x607A>)));
  }

  // ---- objects ----

  std::uint32_t read(std::uint16_t index, std::size_t row) const {
    const ControlOutput& out = controller_.output();
    switch (index) {
      case 0x603F:
        return slipstack::error_code(controller_.state().faults().latched());
      case 0x6041:
        return statusword();
      case 0x6061:
        return static_cast<std::uint32_t>(active_);
      case 0x6064:
        return static_cast<std::uint32_t>(controller_.measured_counts());
      case 0x606C:
        return rounded(in_counts(out.velocity_mps), 2.1e9F);
      case 0x6076:
        return rounded(rated_force_N() * 1e3F, 2.1e9F);
      case 0x6074:
        return rounded(in_thousandths(out.current_A), 32767.0F);
      case 0x6077:
        return rounded(in_thousandths(controller_.measured_A()), 32767.0F);
      case 0x60F4:
        return rounded(in_counts(out.position_error_m), 2.1e9F);
      default:
        return value(row);
    }
  }

  Abort check(std::uint16_t index, std::uint32_t value_now) const {
    switch (index) {
      case 0x6007:
      case 0x605E:
        return value_now == 1 ? Abort::kBadValue : Abort::kNone;  // not offered
      case 0x605A:
        return value_now == 0 || value_now == 2 || value_now == 6 ? Abort::kNone : Abort::kBadValue;
      case 0x6060: {
        const auto mode = static_cast<Mode>(static_cast<std::int8_t>(value_now));
        const bool known = mode == Mode::kNone || mode == Mode::kProfilePosition ||
                           mode == Mode::kCyclicPosition || mode == Mode::kCyclicTorque;
        return known ? Abort::kNone : Abort::kBadValue;
      }
      default:
        return Abort::kNone;
    }
  }

  void written(std::uint16_t index, std::uint32_t value_now) {
    switch (index) {
      case 0x6040:
        return controlword(static_cast<std::uint16_t>(value_now));
      case 0x6060:
        mode_ = static_cast<Mode>(static_cast<std::int8_t>(value_now));
        follow_mode();
        set_torque();
        return command();
      case 0x607A:
        target_written_ = true;
        return;
      case 0x6071:
      case 0x60B2:
        return set_torque();
      default:
        return;
    }
  }

 private:
  std::uint32_t value(std::size_t row) const { return dictionary_->value(row); }

  float rated_force_N() const {
    return static_cast<float>(value(kRow<0x6075>)) * 1e-3F *
           controller_.parameters().axis.motor_constant_N_per_A;
  }
  // Of the rated current, and so of the rated force.
  float in_thousandths(float current_A) const {
    return current_A / (static_cast<float>(value(kRow<0x6075>)) * 1e-6F);
  }
  float in_counts(float metres) const { return metres / controller_.parameters().axis.encoder_resolution_m; }

  bool operation_enabled() const { return controller_.state().state() == DriveState::kOperationEnabled; }
  bool halted() const { return (control_ & kHaltBit) != 0; }

  // Bits of IEC 61800-7-201 table 29; 12 and 13 by mode.
  std::uint16_t statusword() const {
    const DriveState state = controller_.state().state();
    unsigned word_now = status_word(state);
    const bool voltage = controller_.parameters().valid;
    if (voltage) word_now |= 1U << 4;
    if (state == DriveState::kSwitchOnDisabled || state == DriveState::kFault ||
        state == DriveState::kFaultReactionActive || state == DriveState::kNotReadyToSwitchOn) {
      word_now |= (control_ & kQuickStop) != 0 ? 1U << 5 : 0U;
    }
    if (operational_) word_now |= 1U << 9;
    if (controller_.output().limits != 0) word_now |= 1U << 11;
    if (active_ == Mode::kProfilePosition) {
      if (controller_.reference().idle() && !waiting_) word_now |= 1U << 10;
      if (acknowledged_) word_now |= 1U << 12;
    } else if (active_ == Mode::kCyclicPosition) {
      if (controller_.cyclic_position().following()) word_now |= 1U << 12;  // the drive follows the command
    } else if (active_ != Mode::kNone && state == DriveState::kOperationEnabled && !halted()) {
      word_now |= 1U << 12;
    }
    if (controller_.state().faults().latched() == Fault::kFollowingError) word_now |= 1U << 13;
    return static_cast<std::uint16_t>(word_now);
  }

  void controlword(std::uint16_t word_now) {
    const auto rising = static_cast<std::uint16_t>(word_now & ~control_);
    control_ = word_now;
    command();
    follow_cyclic();
    if ((rising & kHaltBit) != 0 && operation_enabled()) {
      controller_.reference().stop();
      waiting_ = target_stands_ = false;
    }
    if (active_ == Mode::kProfilePosition) new_set_point(rising);
  }

  // Quick stop option 0: no braking, current off; fault reaction option 0 the same. Option 6: braked and
  // held, the state kept. Halt leaves torque mode: the axis brakes and holds its place.
  void command() {
    std::uint16_t word_now = control_;
    const bool quick_stop = (word_now & kQuickStop) == 0;
    if (quick_stop && dictionary_ != nullptr && value(kRow<0x605A>) == 0)
      word_now &= static_cast<std::uint16_t>(~kEnableVoltage);
    std::uint32_t options = 0;
    if (active_ == Mode::kCyclicTorque && !halted()) options |= kTorqueMode;
    if (dictionary_ != nullptr && value(kRow<0x605E>) == 0) options |= kReleaseOnFault;
    if (dictionary_ != nullptr && value(kRow<0x605A>) == 6) options |= kStayStopped;
    controller_.command_all(options | word_now);
  }

  // 6071h and 60B2h, in thousandths of the rated force. The target counts in torque mode only, the offset in
  // every mode.
  void set_torque() {
    const float per_thousandth_N = 1e-3F * rated_force_N();
    const auto force_N = [&](std::size_t row) {
      return static_cast<float>(static_cast<std::int32_t>(value(row))) * per_thousandth_N;
    };
    controller_.set_torque(force_N(kRow<0x6071>), force_N(kRow<0x60B2>));
  }

  void follow_mode() {
    if (!operation_enabled()) {
      waiting_ = acknowledged_ = target_stands_ = false;
    }
    if (mode_ == active_) return;
    active_ = mode_;
    follow_cyclic();
    if (operation_enabled()) controller_.reference().stop();
    waiting_ = acknowledged_ = target_stands_ = false;
  }

  // Into cyclic position by mode, by enabling or by the end of a halt, and out of it. No target holds from
  // before: the object starts as the position actual value, and the axis moves when a set-point has come.
  void follow_cyclic() {
    const bool wanted = active_ == Mode::kCyclicPosition && operation_enabled() && !halted();
    if (wanted == cyclic_) return;
    cyclic_ = wanted;
    target_written_ = target_holds_ = false;
    if (!wanted) return controller_.cyclic_position().stop();
    dictionary_->set(kRow<0x607A>, static_cast<std::uint32_t>(controller_.measured_counts()));
    controller_.cyclic_position().start();
  }

  // Controlword bit 4 rises: a set-point, which is the target and the profile as they are now; statusword bit
  // 12 says it was taken and falls with bit 4. A relative target counts from the one before; where there is
  // none, or a halt has given it up, from where the axis is asked to be.
  void new_set_point(std::uint16_t rising) {
    if ((control_ & kNewSetPointBit) == 0) {
      acknowledged_ = false;
      return;
    }
    if ((rising & kNewSetPointBit) == 0 || !operation_enabled() || halted() || waiting_) return;
    const auto target = static_cast<std::int32_t>(value(kRow<0x607A>));
    const std::int32_t from = target_stands_ ? last_target_ : controller_.reference().counts();
    target_ = (control_ & kRelativeBit) != 0 ? sum(from, target) : target;
    profile_ = {value(kRow<0x6081>), value(kRow<0x6083>), value(kRow<0x60A4, 1>)};
    if ((control_ & kImmediatelyBit) != 0) controller_.reference().stop();
    waiting_ = acknowledged_ = true;
  }

  void profile_position() {
    if (!waiting_ || active_ != Mode::kProfilePosition || !operation_enabled()) return;
    if (!controller_.reference().idle()) return;
    const ControlSet& set = controller_.parameters();
    const float tick_s = set.axis.tick_s;
    const auto limit = [](std::uint32_t wanted, float per, float axis) {
      const float own = static_cast<float>(wanted) * per;
      return own < axis ? own : axis;
    };
    const MotionLimits limits{
        limit(profile_.velocity, tick_s, set.axis.velocity_limit_mps / set.mps_per_count),
        limit(profile_.acceleration, tick_s * tick_s, set.axis.acceleration_limit_mps2 / set.mps2_per_count),
        limit(profile_.jerk, tick_s * tick_s * tick_s,
              set.axis.jerk_limit_mps3 / set.mps2_per_count * tick_s)};
    waiting_ = false;
    target_stands_ = true;
    last_target_ = target_;
    static_cast<void>(plan_move(controller_.reference(), target_, limits));
  }

  // 60C2h: value x 10^index seconds.
  float period_s() const {
    float seconds = static_cast<float>(value(kRow<0x60C2, 1>));
    for (auto power = static_cast<std::int32_t>(value(kRow<0x60C2, 2>)); power < 0; ++power) seconds *= 0.1F;
    return seconds;
  }

  static constexpr std::uint16_t kNewSetPointBit = 1U << 4;
  static constexpr std::uint16_t kImmediatelyBit = 1U << 5;
  static constexpr std::uint16_t kRelativeBit = 1U << 6;
  static constexpr std::uint16_t kHaltBit = 1U << 8;

  Controller& controller_;
  Dictionary* dictionary_ = nullptr;
  std::uint16_t control_ = 0;
  Mode mode_ = Mode::kNone;
  Mode active_ = Mode::kNone;
  bool operational_ = false;
  bool cyclic_ = false;           // the reference is the stream's, or waits for it
  bool target_written_ = false;   // since the last SYNC
  bool target_holds_ = false;     // written since the reference is the stream's
  bool target_streamed_ = false;  // by a PDO with SYNC
  bool waiting_ = false;
  bool acknowledged_ = false;
  struct Profile {
    std::uint32_t velocity = 1;      // counts/s
    std::uint32_t acceleration = 1;  // counts/s2
    std::uint32_t jerk = 1;          // counts/s3
  };
  Profile profile_;
  std::int32_t target_ = 0;
  std::int32_t last_target_ = 0;
  bool target_stands_ = false;
};

}  // namespace slipstack::canopen
