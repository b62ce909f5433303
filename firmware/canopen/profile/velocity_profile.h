// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/canopen/profile/profile_context.h"
#include "firmware/control/reference/requested_motion.h"

namespace slipstack::canopen {

/// Profile velocity (IEC 61800-7-201, pv): a change to the target velocity along the profile, from whatever
/// the reference does, and that velocity until another is asked for. Targets that come faster than the tick
/// takes plans over are followed by the last of them.
///
/// At an end of the position range, and at a limit switch, the axis rests until a target points away from
/// there or is 0: a switch that bounces moves nothing.
class VelocityProfile {
 public:
  explicit VelocityProfile(ProfileContext& context) : context_(context), motion_(context.controller) {}

  /// Operation was enabled or disabled, or the mode has changed: no velocity is asked for.
  void begin() {
    context_.dictionary->set(kRow<0x60FF>, 0);
    motion_.forget();
    followed_.reset();
    ended_ = 0;
    target_limited_ = in_window_ = exceeds_ = fast_ = false;
  }

  /// A controlword while this is the mode. Bit 8: the axis halts along the profile, or by the quick stop
  /// ramp; when it falls, the axis goes on.
  void controlword(std::uint16_t changed) {
    if ((changed & ProfileContext::kHaltBit) == 0 || !context_.operation_enabled()) return;
    followed_.reset();
    if (!halts_quickly()) return;
    motion_.forget();
    context_.controller.reference().stop();
  }

  /// In every pass of the main loop while this is the mode.
  void step() {
    if (!context_.operation_enabled()) return;
    follow_windows();
    if (halts_quickly()) return;
    note_end();
    const Profile now = profile_now();
    // A plan that waits for its tick is not replaced: it would never be taken over.
    if (motion_.missed() || (!motion_.waits() && now != followed_)) follow(now);
  }

  /// The axis has other bounds.
  void bounds_changed() { followed_.reset(); }

  /// A velocity is asked for.
  bool moves() const { return target() != 0 && !context_.halted(); }
  /// More is asked for than the limits allow, or the travel has ended.
  bool target_limited() const { return target_limited_ || ended_ != 0; }

  /// Bits 10 and 12 of the statusword: target reached, and the axis stands.
  std::uint16_t status() const {
    return static_cast<std::uint16_t>((target_reached() ? 1U << 10 : 0U) | (fast_ ? 0U : 1U << 12));
  }

 private:
  // As it was planned for.
  struct Profile {
    std::int32_t velocity = 0;
    std::uint32_t acceleration = 1;
    std::uint32_t deceleration = 1;
    std::uint32_t jerk = 1;
    friend bool operator==(const Profile&, const Profile&) = default;
  };
  static constexpr std::uint32_t kByReference = 0xFFFF;  ///< 606Dh

  std::int32_t target() const { return static_cast<std::int32_t>(context_.value(kRow<0x60FF>)); }
  bool halts_quickly() const { return context_.halted() && context_.value(kRow<0x605D>) != 1; }

  Profile profile_now() const {
    return {context_.halted() || ended_ != 0 ? 0 : target(), context_.value(kRow<0x6083>),
            context_.value(kRow<0x6084>), context_.value(kRow<0x60A4, 1>)};
  }

  void follow(const Profile& profile) {
    followed_ = profile;
    const float wanted = context_.velocity_in_ticks(static_cast<float>(profile.velocity));
    MotionLimits limits = context_.limits(1, profile.acceleration, profile.deceleration, profile.jerk);
    limits.velocity = kLargestRate;
    target_limited_ = approx::absolute(wanted) > context_.controller.motion_limits().velocity;
    const PlanStatus status = motion_.run(wanted, limits);
    if (status == PlanStatus::kOk) return;
    // From this motion the axis would leave the range: it is planned again while the axis brakes.
    if (status == PlanStatus::kBeyondRange) return context_.controller.reference().stop();
    context_.controller.inject(Fault::kSetPoint);
  }

  // An axis that rests although it was sent on.
  void note_end() {
    const std::int32_t direction = (target() > 0 ? 1 : 0) - (target() < 0 ? 1 : 0);
    if (ended_ != direction) ended_ = 0;
    const bool sent = followed_ && followed_->velocity != 0 && !motion_.waits();
    if (sent && context_.controller.reference().idle()) ended_ = direction;
  }

  void follow_windows() {
    const Controller& controller = context_.controller;
    const std::uint32_t now = controller.ticks();
    const UserUnits& units = context_.units;
    const float actual = units.velocity_in_user(in_counts(context_.axis(), controller.output().velocity_mps));
    const std::uint32_t window = context_.value(kRow<0x606D>);
    const bool by_reference = window == kByReference;
    const float reached = by_reference ? units.velocity_in_user(context_.demand_counts_per_s()) : actual;
    const float error = approx::absolute(reached - static_cast<float>(target()));
    const bool inside =
        error <= (by_reference ? 1.0F : static_cast<float>(window)) && checked_target_ == target();
    if (!inside || !in_window_) entered_ = now;
    in_window_ = inside;
    checked_target_ = target();
    const bool exceeds = approx::absolute(actual) > static_cast<float>(context_.value(kRow<0x606F>));
    if (!exceeds || !exceeds_) exceeded_ = now;
    exceeds_ = exceeds;
    fast_ = exceeds && seconds(now - exceeded_) >= milliseconds(kRow<0x6070>);
  }

  float seconds(std::uint32_t ticks) const { return static_cast<float>(ticks) * context_.axis().tick_s; }
  float milliseconds(std::size_t row) const { return static_cast<float>(context_.value(row)) * 1e-3F; }

  bool target_reached() const {
    if (context_.halted()) return context_.controller.reference().standing();
    return in_window_ && checked_target_ == target() &&
           seconds(context_.controller.ticks() - entered_) >= milliseconds(kRow<0x606E>);
  }

  ProfileContext& context_;
  RequestedMotion motion_;
  std::optional<Profile> followed_;
  std::int32_t ended_ = 0;  // direction in which the travel has ended, or 0
  bool target_limited_ = false;
  bool in_window_ = false;
  std::int32_t checked_target_ = 0;
  std::uint32_t entered_ = 0;
  bool exceeds_ = false;  // 606Fh
  bool fast_ = false;     // and for 6070h
  std::uint32_t exceeded_ = 0;
};

}  // namespace slipstack::canopen
