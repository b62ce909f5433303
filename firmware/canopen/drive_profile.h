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

  /// Cyclic position: each SYNC takes the target as the next set-point.
  void synchronise() {
    if (active_ != Mode::kCyclicPosition || !operation_enabled() || halted()) return;
    ReferenceGenerator& reference = controller_.reference();
    if (!streaming_) {
      last_target_ = reference.counts();
      stream_.start(reference, period_ticks());
      streaming_ = true;
    }
    // A set-point beyond what the axis may move in a period is taken as far as it may.
    const ControlSet& set = controller_.parameters();
    const float reach = set.axis.velocity_limit_mps / set.mps_per_count * static_cast<float>(period_ticks());
    const auto limit = static_cast<std::int32_t>(approx::clamp(reach, 1.0F, 1.0e6F));
    const std::int32_t way = std::clamp<std::int32_t>(
        difference(static_cast<std::int32_t>(value(kRow<0x607A>)), last_target_), -limit, limit);
    const std::int32_t target = sum(last_target_, way);
    if (stream_.push(reference, target)) last_target_ = target;
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
      if (target_reached()) word_now |= 1U << 10;
      if (acknowledged_) word_now |= 1U << 12;
    } else if (active_ != Mode::kNone && state == DriveState::kOperationEnabled && !halted()) {
      word_now |= 1U << 12;  // the drive follows the command
    }
    if (controller_.state().faults().latched() == Fault::kFollowingError) word_now |= 1U << 13;
    return static_cast<std::uint16_t>(word_now);
  }

  void controlword(std::uint16_t word_now) {
    const auto changed = static_cast<std::uint16_t>(word_now ^ control_);
    const auto rising = static_cast<std::uint16_t>(word_now & changed);
    control_ = word_now;
    command();
    if (active_ == Mode::kProfilePosition) {
      halt_or_go_on(changed);
      new_set_point(rising);
    } else if ((rising & kHaltBit) != 0 && operation_enabled()) {
      controller_.reference().stop();
      streaming_ = false;
    }
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
    if (!operation_enabled()) give_up();
    if (mode_ == active_) return;
    if (operation_enabled()) controller_.reference().stop();
    active_ = mode_;
    give_up();
  }

  void give_up() {
    streaming_ = waiting_ = acknowledged_ = target_stands_ = moving_ = false;
    request_ = Request::kNone;
  }

  // ---- profile position ----

  // Controlword bit 4 rises: a set-point, which is the target and the profile as they are now; statusword bit
  // 12 says it was taken and falls with bit 4. It waits until the one before has arrived, unless bit 5 says
  // at once. A relative target counts from the one before, or from where the axis is asked to be.
  void new_set_point(std::uint16_t rising) {
    if ((control_ & kNewSetPointBit) == 0) {
      acknowledged_ = false;
      return;
    }
    if ((rising & kNewSetPointBit) == 0 || !operation_enabled() || halted() || waiting_) return;
    const auto target = static_cast<std::int32_t>(value(kRow<0x607A>));
    const std::int64_t from = target_stands_ ? target_ : controller_.reference().counts();
    const std::int64_t wanted = (control_ & kRelativeBit) != 0 ? from + target : target;
    acknowledged_ = true;
    if (wanted != static_cast<std::int32_t>(wanted)) return controller_.inject(Fault::kSetPoint);
    next_target_ = static_cast<std::int32_t>(wanted);
    next_profile_ = {value(kRow<0x6081>), value(kRow<0x6083>), value(kRow<0x6084>), value(kRow<0x60A4, 1>)};
    waiting_ = true;
    if (!moving_ || (control_ & kImmediatelyBit) != 0) begin_move();
  }

  void begin_move() {
    waiting_ = in_window_ = false;
    moving_ = target_stands_ = true;
    target_ = next_target_;
    profile_ = next_profile_;
    request(Request::kMove);
  }

  // Bit 8: the axis halts along the profile; when it falls, the move goes on.
  void halt_or_go_on(std::uint16_t changed) {
    if ((changed & kHaltBit) == 0 || !operation_enabled()) return;
    if (halted()) {
      request(Request::kHalt);
    } else if (moving_) {
      request(Request::kMove);
    }
  }

  enum class Request : std::uint8_t { kNone, kMove, kHalt };

  // The tick may be gone past a plan before it is ready: it is then asked for again by step().
  void request(Request what) {
    request_ = what;
    plans_before_ = controller_.reference().plans_taken();
    const PlanStatus status =
        what == Request::kHalt ? controller_.halt(limits()) : controller_.move_to(target_, limits());
    if (status == PlanStatus::kOk || status == PlanStatus::kBusy) return;
    request_ = Request::kNone;
    moving_ = false;
    controller_.inject(Fault::kSetPoint);
  }

  void profile_position() {
    if (active_ != Mode::kProfilePosition || !operation_enabled()) return;
    const ReferenceGenerator& reference = controller_.reference();
    if (request_ != Request::kNone && !reference.plan_waits()) {
      if (reference.plans_taken() == plans_before_) return request(request_);
      request_ = Request::kNone;
    }
    if (moving_ && !halted() && reference.idle()) {
      // Something else may have stopped it.
      if (reference.counts() != target_) return request(Request::kMove);
      moving_ = false;
    }
    if (waiting_ && !moving_) begin_move();
    follow_window();
  }

  // The axis is where it was sent, within 6067h for 6068h; 6067h = FFFFFFFFh: the reference is.
  void follow_window() {
    const std::uint32_t now = controller_.ticks();
    const std::int32_t target = target_stands_ ? target_ : controller_.reference().counts();
    const std::int32_t error = difference(controller_.measured_counts(), target);
    const std::uint32_t distance =
        error < 0 ? 0U - static_cast<std::uint32_t>(error) : static_cast<std::uint32_t>(error);
    const bool inside = !moving_ && distance <= value(kRow<0x6067>);
    if (!inside || !in_window_) entered_ = now;
    in_window_ = inside;
    const float wait_s = static_cast<float>(value(kRow<0x6068>)) * 1e-3F;
    const bool off = value(kRow<0x6067>) == 0xFFFFFFFFU;
    settled_ = inside &&
               (off || static_cast<float>(now - entered_) * controller_.parameters().axis.tick_s >= wait_s);
  }

  bool target_reached() const {
    if (halted()) return controller_.reference().standing();
    return settled_ && !moving_ && !waiting_;
  }

  MotionLimits limits() const {
    const float tick_s = controller_.parameters().axis.tick_s;
    const auto in_ticks = [](std::uint32_t per_second, float scale) {
      return static_cast<float>(per_second) * scale;
    };
    return {in_ticks(profile_.velocity, tick_s), in_ticks(profile_.acceleration, tick_s * tick_s),
            in_ticks(profile_.deceleration, tick_s * tick_s),
            in_ticks(profile_.jerk, tick_s * tick_s * tick_s)};
  }

  // 60C2h: value x 10^index seconds.
  std::int32_t period_ticks() const {
    float period_s = static_cast<float>(value(kRow<0x60C2, 1>));
    for (auto power = static_cast<std::int32_t>(value(kRow<0x60C2, 2>)); power < 0; ++power) period_s *= 0.1F;
    const float ticks = period_s / controller_.parameters().axis.tick_s + 0.5F;
    constexpr auto kLongest = static_cast<float>(SetpointStream::kLongestPeriod);
    return static_cast<std::int32_t>(approx::clamp(ticks, 1.0F, kLongest));
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
  bool streaming_ = false;
  bool waiting_ = false;
  bool acknowledged_ = false;
  struct Profile {
    std::uint32_t velocity = 1;      // counts/s
    std::uint32_t acceleration = 1;  // counts/s2
    std::uint32_t deceleration = 1;  // counts/s2
    std::uint32_t jerk = 1;          // counts/s3
  };
  Profile profile_;
  Profile next_profile_;
  std::int32_t target_ = 0;
  std::int32_t next_target_ = 0;
  bool moving_ = false;
  Request request_ = Request::kNone;
  std::uint32_t plans_before_ = 0;
  bool in_window_ = false;
  bool settled_ = false;
  std::uint32_t entered_ = 0;
  std::int32_t last_target_ = 0;  // of the stream
  bool target_stands_ = false;
  SetpointStream stream_;
};

}  // namespace slipstack::canopen
