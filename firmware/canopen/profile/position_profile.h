// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/profile/profile_context.h"
#include "firmware/control/reference/requested_motion.h"

namespace slipstack::canopen {

/// Profile position (IEC 61800-7-201, pp): set-points one after the other, halt, and the position window.
class PositionProfile {
 public:
  explicit PositionProfile(ProfileContext& context) : context_(context), motion_(context.controller) {}

  /// A controlword while this is the mode.
  void controlword(std::uint16_t changed, std::uint16_t rising) {
    halt_or_go_on(changed);
    new_set_point(rising);
  }

  /// In every pass of the main loop while this is the mode.
  void step() {
    if (!context_.operation_enabled()) return;
    if (motion_.missed()) return begun(motion_.again());
    const ReferenceGenerator& reference = context_.controller.reference();
    if (moving_ && !context_.halted() && reference.idle()) {
      // Something else may have stopped it. Where a limit switch or another range did, it stays there.
      if (nearest(target_) != target_) {
        target_ = reference.counts();
        target_limited_ = true;
      }
      if (reference.counts() != target_) return move();
      moving_ = false;
    }
    if (waiting_ && !moving_) begin_move();
    follow_window();
  }

  /// The axis has other bounds: the range may have become narrower than the move under way.
  void bounds_changed() {
    if (!moving_ || context_.halted() || nearest(target_) == target_) return;
    target_ = nearest(target_);
    target_limited_ = true;
    move();
  }

  /// Another mode, or operation is disabled.
  void give_up() {
    waiting_ = acknowledged_ = target_stands_ = moving_ = target_limited_ = false;
    motion_.forget();
  }

  /// Bits 10 and 12 of the statusword.
  std::uint16_t status() const {
    return static_cast<std::uint16_t>((target_reached() ? 1U << 10 : 0U) | (acknowledged_ ? 1U << 12 : 0U));
  }
  /// The target is an end of the position range, another was asked for.
  bool target_limited() const { return target_limited_; }

 private:
  static constexpr std::uint16_t kNewSetPointBit = 1U << 4;
  static constexpr std::uint16_t kImmediatelyBit = 1U << 5;
  static constexpr std::uint16_t kRelativeBit = 1U << 6;

  std::int32_t nearest(std::int32_t counts) const { return context_.controller.range().nearest(counts); }
  bool asks(std::uint16_t bit) const { return (context_.control & bit) != 0; }

  // Controlword bit 4 rises: a set-point, which is the target and the profile as they are now; statusword bit
  // 12 says it was taken and falls with bit 4. It waits until the one before has arrived, unless bit 5 says
  // at once. A relative target counts from the one before, or from where the axis is asked to be.
  void new_set_point(std::uint16_t rising) {
    if (!asks(kNewSetPointBit)) {
      acknowledged_ = false;
      return;
    }
    if ((rising & kNewSetPointBit) == 0 || !context_.operation_enabled() || context_.halted() || waiting_)
      return;
    Controller& controller = context_.controller;
    const std::int64_t from = context_.place(target_stands_ ? target_ : controller.reference().counts());
    const std::int64_t asked = asks(kRelativeBit) ? from + context_.target() : context_.target();
    const std::int64_t origin = controller.position().origin();
    const std::int64_t wanted = controller.range().nearest(asked + origin) - origin;
    acknowledged_ = true;
    next_limited_ = wanted != asked;
    if (wanted != static_cast<std::int32_t>(wanted)) return controller.inject(Fault::kSetPoint);
    next_target_ = controller.position().counts_of(static_cast<std::int32_t>(wanted));
    next_profile_ = profile_now();
    waiting_ = true;
    if (!moving_ || asks(kImmediatelyBit)) begin_move();
  }

  void begin_move() {
    waiting_ = in_window_ = false;
    moving_ = target_stands_ = true;
    target_ = next_target_;
    target_limited_ = next_limited_;
    profile_ = next_profile_;
    move();
  }

  // Bit 8: the axis halts along the profile; when it falls, the move goes on.
  void halt_or_go_on(std::uint16_t changed) {
    if ((changed & ProfileContext::kHaltBit) == 0 || !context_.operation_enabled()) return;
    if (context_.halted()) {
      if (context_.value(kRow<0x605D>) == 1) return begun(motion_.halt(limits()));
      motion_.forget();
      context_.controller.reference().stop();
    } else if (moving_) {
      move();
    }
  }

  void move() { begun(motion_.move_to(target_, limits())); }

  void begun(PlanStatus status) {
    if (status == PlanStatus::kOk) return;
    if (status == PlanStatus::kBeyondRange) return context_.controller.reference().stop();
    moving_ = false;
    context_.controller.inject(Fault::kSetPoint);
  }

  // The axis is where it was sent, within 6067h for 6068h; 6067h = FFFFFFFFh: the reference is.
  void follow_window() {
    const Controller& controller = context_.controller;
    const std::uint32_t now = controller.ticks();
    const std::int32_t target = target_stands_ ? target_ : controller.reference().counts();
    const std::int32_t error = difference(controller.measured_counts(), target);
    const std::uint32_t distance =
        error < 0 ? 0U - static_cast<std::uint32_t>(error) : static_cast<std::uint32_t>(error);
    const std::uint32_t window = context_.value(kRow<0x6067>);
    const bool inside = !moving_ && distance <= context_.units.width_in_counts(window);
    if (!inside || !in_window_) entered_ = now;
    in_window_ = inside;
    const float wait_s = static_cast<float>(context_.value(kRow<0x6068>)) * 1e-3F;
    const bool off = window == 0xFFFFFFFFU;
    settled_ = inside && (off || static_cast<float>(now - entered_) * context_.axis().tick_s >= wait_s);
  }

  bool target_reached() const {
    if (context_.halted()) return context_.controller.reference().standing();
    return settled_ && !moving_ && !waiting_;
  }

  // Of a set-point, in the user's unit and seconds.
  struct Profile {
    std::uint32_t velocity = 1;
    std::uint32_t acceleration = 1;
    std::uint32_t deceleration = 1;
    std::uint32_t jerk = 1;
  };
  Profile profile_now() const {
    return {context_.value(kRow<0x6081>), context_.value(kRow<0x6083>), context_.value(kRow<0x6084>),
            context_.value(kRow<0x60A4, 1>)};
  }

  MotionLimits limits() const {
    return context_.limits(profile_.velocity, profile_.acceleration, profile_.deceleration, profile_.jerk);
  }

  ProfileContext& context_;
  RequestedMotion motion_;
  Profile profile_;
  Profile next_profile_;
  std::int32_t target_ = 0;
  std::int32_t next_target_ = 0;
  bool waiting_ = false;
  bool acknowledged_ = false;
  bool moving_ = false;
  bool in_window_ = false;
  bool settled_ = false;
  std::uint32_t entered_ = 0;
  bool target_stands_ = false;
  bool target_limited_ = false;
  bool next_limited_ = false;
};

}  // namespace slipstack::canopen
