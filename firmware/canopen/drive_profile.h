// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "firmware/canopen/command_supervision.h"
#include "firmware/canopen/dictionary.h"
#include "firmware/canopen/homing_profile.h"
#include "firmware/canopen/profile_units.h"
#include "firmware/canopen/telemetry.h"
#include "firmware/canopen/user_units.h"
#include "firmware/control/controller.h"
#include "firmware/control/plan_handshake.h"

namespace slipstack::canopen {

enum class Mode : std::int8_t {
  kNone = 0,
  kProfilePosition = 1,
  kHoming = 6,
  kCyclicPosition = 8,
  kCyclicTorque = 10
};

/// The drive profile CiA 402 (IEC 61800-7-201): control word and status word, modes of operation, set-points,
/// and the option codes of stops. Bound to the controller; in the main loop.
class DriveProfile {
 public:
  explicit DriveProfile(Controller& controller)
      : controller_(controller), supervision_(controller), homing_(controller, units_) {}

  /// The dictionary holds other values, after a start or a reset: the axis is stopped, and until end_reset()
  /// no controlword is followed.
  void begin_reset(Dictionary& dictionary) {
    dictionary_ = &dictionary;
    take_units();
    resetting_ = true;
    control_ = 0;
    mode_ = Mode::kNone;
    command();
  }
  void end_reset() {
    resetting_ = false;
    command();
  }

  /// Once in every poll.
  void step() {
    if (supervision_.lost()) connection_lost();
    follow_mode();
    follow_cyclic();
    follow_bounds();
    command();
    profile_position();
    if (active_ == Mode::kHoming) homing_.step(*dictionary_, operation_enabled());
  }

  bool driving() const { return controller_.driving(); }
  void set_operational(bool operational) { operational_ = operational; }

  /// 6007h: what follows when the master is lost.
  void connection_lost() {
    if (!driving()) return;
    control_ = static_cast<std::uint16_t>(control_ & ~CommandSupervision::reaction(*dictionary_));
    command();
  }

  /// 603Fh: the fault, or that commands fail to come (8100h: communication).
  std::uint16_t error_code() const {
    const Fault fault = controller_.state().faults().latched();
    return fault == Fault::kNone && supervision_.lost() ? 0x8100 : slipstack::error_code(fault);
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
    cyclic.set_range(controller_.range());
    if (target_written_) target_streamed_ = with_sync;
    target_holds_ = target_holds_ || target_written_;
    const bool has_target = target_written_ || (target_holds_ && !target_streamed_);
    target_written_ = false;
    cyclic.sync(controller_.ticks(), has_target, controller_.position().counts_of(target()));
  }

  // ---- objects ----

  std::uint32_t read(std::uint16_t index, std::size_t row) const {
    const ControlOutput& out = controller_.output();
    switch (index) {
      case 0x603F:
        return error_code();
      case 0x6041:
        return statusword();
      case 0x6061:
        return static_cast<std::uint32_t>(active_);
      case 0x6063:
        return static_cast<std::uint32_t>(place(controller_.measured_counts()));
      case 0x6064:
        return position();
      case 0x606C:
        return rounded(units_.velocity_in_user(in_counts(axis(), out.velocity_mps)), 2.1e9F);
      case 0x6076:
        return rounded(rated_force_N(*dictionary_, axis()) * 1e3F, 2.1e9F);
      case 0x6074:
        return rounded(in_thousandths(*dictionary_, out.current_A), 32767.0F);
      case 0x6077:
        return rounded(in_thousandths(*dictionary_, controller_.measured_A()), 32767.0F);
      case 0x60F4:
        return rounded(units_.distance_in_user(in_counts(axis(), out.position_error_m)), 2.1e9F);
      case 0x60FD:
        return controller_.inputs().word(controller_.parameters().io);
      default:
        return value(row);
    }
  }

  Abort check(std::size_t row, std::uint32_t value_now) const {
    switch (kObjects[row].index) {
      case 0x6007:
        return value_now == 1 ? Abort::kBadValue : Abort::kNone;  // not offered
      case 0x605A:                                                // not by the current limit, 3 and 7
        return value_now == 3 || value_now == 4 ? Abort::kBadValue : Abort::kNone;
      case 0x6060: {
        const auto mode = static_cast<Mode>(static_cast<std::int8_t>(value_now));
        const bool known = mode == Mode::kNone || mode == Mode::kProfilePosition || mode == Mode::kHoming ||
                           mode == Mode::kCyclicPosition || mode == Mode::kCyclicTorque;
        return known ? Abort::kNone : Abort::kBadValue;
      }
      case 0x607A:
      case 0x607C: {
        const auto wanted = static_cast<std::int32_t>(value_now);
        if (units_.to_counts(wanted)) return Abort::kNone;
        return wanted < 0 ? Abort::kTooLow : Abort::kTooHigh;
      }
      case 0x607E:
        if ((value_now & ~(UserUnits::kPosition | UserUnits::kVelocity)) != 0) return Abort::kBadValue;
        return Abort::kNone;
      case 0x608F:
      case 0x6091:
      case 0x6092:
        return UserUnits::of(*dictionary_, row, value_now) ? Abort::kNone : Abort::kBadValue;
      case 0x6098:
        return HomingProfile::supported(value_now) ? Abort::kNone : Abort::kBadValue;
      default:
        return Abort::kNone;
    }
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
        target_written_ = true;
        return;
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
      case kBrakeIndex:
        bounds_changed_ = true;
        return;
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
  std::uint32_t value(std::size_t row) const { return dictionary_->value(row); }

  const AxisParameters& axis() const { return controller_.parameters().axis; }

  // Counts from position zero.
  std::int32_t place(std::int32_t counts) const { return controller_.position().position_of(counts); }

  // And not on the way out of it.
  bool operation_enabled() const { return controller_.state().follows_commands(); }
  bool halted() const { return (control_ & kHaltBit) != 0; }

  // A command of the master: controlword, mode, or set-point. A loss that the main loop has not seen yet
  // takes effect first, so that a command that comes late does not undo it.
  void received(std::uint16_t index) {
    const bool set_point = index == 0x607A || index == 0x6071;
    if (!set_point && index != 0x6040 && index != 0x6060 && index != 0x60B2) return;
    if (supervision_.lost()) connection_lost();
    supervision_.received(*dictionary_, set_point && operation_enabled());
  }

  // Bits of IEC 61800-7-201 table 29; 12 and 13 by mode. 15, of the manufacturer: the position is referenced.
  std::uint16_t statusword() const {
    const DriveState state = controller_.state().state();
    unsigned word_now = status_word(state);
    const bool voltage = controller_.parameters().valid;
    if (voltage && controller_.inputs().amplifier_ready(controller_.parameters().io)) word_now |= 1U << 4;
    if (state == DriveState::kSwitchOnDisabled || state == DriveState::kFault ||
        state == DriveState::kFaultReactionActive || state == DriveState::kNotReadyToSwitchOn) {
      word_now |= (control_ & kQuickStop) != 0 ? 1U << 5 : 0U;
    }
    if (operational_) word_now |= 1U << 9;
    if (controller_.output().limits != 0 || target_limited_ || controller_.thermal().reduces())
      word_now |= 1U << 11;
    if (active_ == Mode::kProfilePosition) {
      if (target_reached()) word_now |= 1U << 10;
      if (acknowledged_) word_now |= 1U << 12;
    } else if (active_ == Mode::kHoming) {
      word_now |= homing_.status();
    } else if (active_ == Mode::kCyclicPosition) {
      if (controller_.cyclic_position().limited()) word_now |= 1U << 11;
      if (controller_.cyclic_position().following()) word_now |= 1U << 12;  // the drive follows the command
    } else if (active_ != Mode::kNone && state == DriveState::kOperationEnabled && !halted()) {
      word_now |= 1U << 12;
    }
    if (controller_.state().faults().latched() == Fault::kFollowingError) word_now |= 1U << 13;
    if (controller_.position().referenced()) word_now |= 1U << 15;
    return static_cast<std::uint16_t>(word_now);
  }

  void controlword(std::uint16_t word_now) {
    if (resetting_) return;
    const auto changed = static_cast<std::uint16_t>(word_now ^ control_);
    const auto rising = static_cast<std::uint16_t>(word_now & changed);
    control_ = word_now;
    follow_cyclic();
    if (active_ == Mode::kProfilePosition) {
      halt_or_go_on(changed);
      new_set_point(rising);
    } else if (active_ == Mode::kHoming) {
      homing_.controlword(*dictionary_, word_now, changed, operation_enabled());
    } else if ((rising & kHaltBit) != 0 && operation_enabled()) {
      controller_.reference().stop();
    }
  }

  // Options 0: no braking, current off. Quick stop options 5 and 6: braked and held, the state kept. Halt
  // leaves torque mode: the axis brakes and holds its place.
  void command() {
    if (resetting_) {
      // A quick stop, or current off.
      return controller_.command(
          Command{.word = value(kRow<0x605A>) != 0 ? std::uint32_t{kEnableVoltage} : 0U});
    }
    std::uint16_t word_now = control_;
    const bool quick_stop = (word_now & kQuickStop) == 0;
    if (quick_stop && value(kRow<0x605A>) == 0) word_now &= static_cast<std::uint16_t>(~kEnableVoltage);
    std::uint32_t options = 0;
    if (active_ == Mode::kCyclicTorque && !halted()) options |= kTorqueMode;
    options |= stop_options() | supervision();
    controller_.set_outputs(value(kRow<0x60FE, 1>) & value(kRow<0x60FE, 2>));
    controller_.command(Command{options | word_now, force_N(kRow<0x6071>), force_N(kRow<0x60B2>)});
  }

  std::uint32_t stop_options() const {
    const std::uint32_t quick_stop = value(kRow<0x605A>);
    const std::uint32_t fault = value(kRow<0x605E>);
    std::uint32_t options = 0;
    if (quick_stop >= 5) options |= kStayStopped;
    if (quick_stop == 1 || quick_stop == 5) options |= kSlowQuickStop;
    if (value(kRow<0x605B>) == 1) options |= kBrakeOnShutdown;
    if (value(kRow<0x605C>) == 1) options |= kBrakeOnDisable;
    if (value(kRow<0x605D>) == 1) options |= kSlowHalt;
    if (fault == 0) options |= kReleaseOnFault;
    if (fault == 1) options |= kSlowFaultReaction;
    return options;
  }

  // 607Dh in counts; the last number there is bounds nothing.
  PositionRange software_limits() const {
    constexpr std::int32_t kMin = PositionRange::kNoLowest;
    constexpr std::int32_t kMax = PositionRange::kNoHighest;
    const std::optional<std::int32_t> first = range_end(kRow<0x607D, 1>, kMin);
    const std::optional<std::int32_t> second = range_end(kRow<0x607D, 2>, kMax);
    if (units_.turned()) return {second.value_or(kMin), first.value_or(kMax)};
    return {first.value_or(kMin), second.value_or(kMax)};
  }
  std::optional<std::int32_t> range_end(std::size_t row, std::int32_t none) const {
    const auto end = static_cast<std::int32_t>(value(row));
    const std::optional<std::int32_t> from_zero = units_.to_counts(end);
    if (end == none || !from_zero) return std::nullopt;
    const std::int64_t counts = std::int64_t{*from_zero} + range_origin_;
    if (counts != static_cast<std::int32_t>(counts)) return std::nullopt;
    return static_cast<std::int32_t>(counts);
  }

  // In counts; as delivered nothing is bounded, whatever the user's unit is.
  float bound_in_counts(std::size_t row) const {
    if (value(row) == 0xFFFFFFFFU) return UserBounds::kNone;
    return static_cast<float>(value(row)) * units_.counts_per_user();
  }

  // What objects bound motion by, to the tick. Positions bound where they are referenced, and homing looks
  // for the switches that bound otherwise.
  void follow_bounds() {
    const bool homing = active_ == Mode::kHoming;
    const PositionReference& place = controller_.position();
    const bool ranged = place.referenced() && !homing;
    if (ranged != ranged_ || homing == switches_ || place.origin() != range_origin_) bounds_changed_ = true;
    if (!bounds_changed_) return;
    bounds_changed_ = false;
    ranged_ = ranged;
    switches_ = !homing;
    range_origin_ = place.origin();
    const auto real = [this](std::size_t row) { return static_cast<float>(value(row)); };
    UserBounds user;
    if (ranged) user.range = software_limits();
    user.switches = switches_;
    user.velocity_mps = real(kRow<0x6080>) * 1e-3F;
    user.profile_velocity_counts_per_s = bound_in_counts(kRow<0x607F>);
    user.quick_stop_counts_per_s2 = bound_in_counts(kRow<0x6085>);
    user.slow_down_counts_per_s2 = bound_in_counts(kRow<0x6084>);
    user.slow_down_counts_per_s3 = bound_in_counts(kRow<0x60A4, 1>);
    user.brake_release_s = real(kRow<kBrakeIndex, 1>) * 1e-3F;
    user.brake_apply_s = real(kRow<kBrakeIndex, 2>) * 1e-3F;
    controller_.bound(user);
    if (!moving_ || halted() || controller_.range().nearest(target_) == target_) return;
    // The range has become narrower than the move under way.
    target_ = controller_.range().nearest(target_);
    target_limited_ = true;
    request(Request::kMove);
  }

  // In the cyclic modes, from the first set-point on; a force that was there before counts as one.
  std::uint32_t supervision() const {
    const bool torque = active_ == Mode::kCyclicTorque;
    if (!operation_enabled() || (!torque && active_ != Mode::kCyclicPosition)) return 0;
    const bool forced = torque && (value(kRow<0x6071>) != 0 || value(kRow<0x60B2>) != 0);
    return supervision_.options(*dictionary_, target_holds_ || forced);
  }

  // 6071h or 60B2h, in thousandths of the rated force. The target counts in torque mode only, the offset in
  // every mode.
  float force_N(std::size_t row) const {
    const float thousandths = static_cast<float>(static_cast<std::int32_t>(value(row)));
    return thousandths * 1e-3F * rated_force_N(*dictionary_, axis());
  }

  void follow_mode() {
    if (!operation_enabled()) {
      give_up();
      supervision_.rest();
    }
    if (mode_ == active_) return;
    active_ = mode_;
    homing_.reset();
    supervision_.rest();
    follow_cyclic();
    if (operation_enabled()) controller_.reference().stop();
    give_up();
  }

  // Into cyclic position by mode, by enabling or by the end of a halt, and out of it. No target holds from
  // before: the object starts as the position actual value, and the axis moves when a set-point has come.
  void follow_cyclic() {
    const bool wanted = active_ == Mode::kCyclicPosition && operation_enabled() && !halted();
    if (wanted == cyclic_) return;
    cyclic_ = wanted;
    target_written_ = target_holds_ = false;
    if (!wanted) return controller_.cyclic_position().stop();
    dictionary_->set(kRow<0x607A>, position());
    controller_.cyclic_position().start();
  }

  void give_up() {
    waiting_ = acknowledged_ = target_stands_ = moving_ = target_limited_ = false;
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
    const std::int64_t from = place(target_stands_ ? target_ : controller_.reference().counts());
    const std::int64_t asked = (control_ & kRelativeBit) != 0 ? from + target() : target();
    const std::int64_t origin = controller_.position().origin();
    const std::int64_t wanted = controller_.range().nearest(asked + origin) - origin;
    acknowledged_ = true;
    next_limited_ = wanted != asked;
    if (wanted != static_cast<std::int32_t>(wanted)) return controller_.inject(Fault::kSetPoint);
    next_target_ = controller_.position().counts_of(static_cast<std::int32_t>(wanted));
    next_profile_ = {value(kRow<0x6081>), value(kRow<0x6083>), value(kRow<0x6084>), value(kRow<0x60A4, 1>)};
    waiting_ = true;
    if (!moving_ || (control_ & kImmediatelyBit) != 0) begin_move();
  }

  void begin_move() {
    waiting_ = in_window_ = false;
    moving_ = target_stands_ = true;
    target_ = next_target_;
    target_limited_ = next_limited_;
    profile_ = next_profile_;
    request(Request::kMove);
  }

  // Bit 8: the axis halts along the profile; when it falls, the move goes on.
  void halt_or_go_on(std::uint16_t changed) {
    if ((changed & kHaltBit) == 0 || !operation_enabled()) return;
    if (halted()) {
      if (value(kRow<0x605D>) == 1) return request(Request::kHalt);
      request_ = Request::kNone;
      controller_.reference().stop();
    } else if (moving_) {
      request(Request::kMove);
    }
  }

  enum class Request : std::uint8_t { kNone, kMove, kHalt };

  void request(Request what) {
    request_ = what;
    handshake_.begin(controller_.reference());
    const PlanStatus status =
        what == Request::kHalt ? controller_.halt(limits()) : controller_.move_to(target_, limits());
    if (status == PlanStatus::kOk || status == PlanStatus::kBusy) return;
    if (status == PlanStatus::kBeyondRange) return controller_.reference().stop();
    request_ = Request::kNone;
    moving_ = false;
    controller_.inject(Fault::kSetPoint);
  }

  void profile_position() {
    if (active_ != Mode::kProfilePosition || !operation_enabled()) return;
    const ReferenceGenerator& reference = controller_.reference();
    if (request_ != Request::kNone) {
      const PlanHandshake::State plan = handshake_.of(reference);
      if (plan == PlanHandshake::State::kMissed) return request(request_);
      if (plan == PlanHandshake::State::kTaken) request_ = Request::kNone;
    }
    if (moving_ && !halted() && reference.idle()) {
      // Something else may have stopped it. Where a limit switch or another range did, it stays there.
      if (controller_.range().nearest(target_) != target_) {
        target_ = reference.counts();
        target_limited_ = true;
      }
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
    const bool inside = !moving_ && distance <= units_.width_in_counts(value(kRow<0x6067>));
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
    const auto in_ticks = [this](std::uint32_t per_second, float scale) {
      return static_cast<float>(per_second) * (units_.counts_per_user() * scale);
    };
    return {in_ticks(profile_.velocity, tick_s), in_ticks(profile_.acceleration, tick_s * tick_s),
            in_ticks(profile_.deceleration, tick_s * tick_s),
            in_ticks(profile_.jerk, tick_s * tick_s * tick_s)};
  }

  // A target from before would mean another place.
  void take_units() {
    units_ = UserUnits::of(*dictionary_).value_or(UserUnits{});
    bounds_changed_ = true;
    dictionary_->set(kRow<0x607A>, position());
  }

  // 6064h, 607Ah: the user's unit outside, counts inside. What does not fit was refused when it was written.
  std::uint32_t position() const {
    return static_cast<std::uint32_t>(units_.to_user(place(controller_.measured_counts())));
  }
  // In counts: from position zero, or a distance.
  std::int32_t target() const {
    return units_.to_counts(static_cast<std::int32_t>(value(kRow<0x607A>)))
        .value_or(place(controller_.measured_counts()));
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
  CommandSupervision supervision_;
  UserUnits units_;
  HomingProfile homing_;
  Dictionary* dictionary_ = nullptr;
  std::uint16_t control_ = 0;
  Mode mode_ = Mode::kNone;
  Mode active_ = Mode::kNone;
  bool operational_ = false;
  bool resetting_ = false;
  bool cyclic_ = false;           // the reference is the stream's, or waits for it
  bool target_written_ = false;   // since the last SYNC
  bool target_holds_ = false;     // written since the reference is the stream's
  bool target_streamed_ = false;  // by a PDO with SYNC
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
  PlanHandshake handshake_;
  bool in_window_ = false;
  bool settled_ = false;
  std::uint32_t entered_ = 0;
  bool target_stands_ = false;
  bool target_limited_ = false;  // the target is an end of the position range, another was asked for
  bool next_limited_ = false;
  bool bounds_changed_ = false;
  bool ranged_ = false;  // as the bounds were given last
  bool switches_ = true;
  std::int32_t range_origin_ = 0;
};

}  // namespace slipstack::canopen
