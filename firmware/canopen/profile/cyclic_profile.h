// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "firmware/canopen/profile/profile_context.h"

namespace slipstack::canopen {

/// Cyclic synchronous position and velocity (IEC 61800-7-201, csp and csv): targets and SYNC to the stream
/// that the reference follows.
class CyclicProfile {
 public:
  explicit CyclicProfile(ProfileContext& context) : context_(context) {}

  /// Into a cyclic mode, by 6060h, by enabling or by the end of a halt, and out of it. No target holds from
  /// before: the object starts as the position actual value, or as no velocity, and the axis moves when a
  /// set-point has come.
  void follow() {
    const Mode wanted =
        context_.operation_enabled() && !context_.halted() ? cyclic(context_.mode) : Mode::kNone;
    if (wanted == streamed_) return;
    streamed_ = wanted;
    target_written_ = target_holds_ = false;
    stream().stop();
    if (wanted == Mode::kNone) return;
    context_.dictionary->set(kRow<0x607A>, context_.position());
    context_.dictionary->set(kRow<0x60FF>, 0);
    stream().start();
  }

  /// 607Ah was written, or in cyclic velocity 60FFh or 60B1h.
  void target_written() { target_written_ = true; }
  /// A target was written since the reference is the stream's.
  bool target_holds() const { return target_holds_; }

  /// SYNC makes a set-point of the target. One that a synchronous PDO brings must come with every SYNC; any
  /// other holds until it is written again. `with_sync`: a PDO brought it just now.
  void synchronise(bool with_sync) {
    follow();
    Controller& controller = context_.controller;
    const ControlSet& set = controller.parameters();
    stream().set_period(period_s() / set.axis.tick_s, set.axis.tick_s);
    if (target_written_) target_streamed_ = with_sync;
    target_holds_ = target_holds_ || target_written_;
    const bool has_target = target_written_ || (target_holds_ && !target_streamed_);
    target_written_ = false;
    if (streamed_ == Mode::kCyclicVelocity) return synchronise_velocity(has_target);
    const float counts_per_unit = context_.units.counts_per_user();
    const float rounding = CyclicPosition::kRounding * std::max(1.0F, counts_per_unit);
    path_.set_limits(stream().path_limits(controller.stream_limits(), controller.range(), rounding));
    stream().sync(controller.ticks(), has_target,
                  controller.position().counts_of(context_.target_with_offset()), path_, Ahead{controller});
  }

  /// Bits 11 and 12 of the statusword.
  std::uint16_t status() const {
    const CyclicPosition& stream = context_.controller.cyclic_position();
    const bool limited = stream.following() && path_.limited();
    return static_cast<std::uint16_t>((limited ? 1U << 11 : 0U) | (stream.following() ? 1U << 12 : 0U));
  }

 private:
  // Of the reference, in so many ticks.
  struct Ahead {
    const Controller& controller;
    Motion operator()(std::uint32_t lead) const { return controller.ahead(lead); }
  };

  static Mode cyclic(Mode mode) {
    return mode == Mode::kCyclicPosition || mode == Mode::kCyclicVelocity ? mode : Mode::kNone;
  }

  void synchronise_velocity(bool has_target) {
    Controller& controller = context_.controller;
    const float wanted = static_cast<float>(static_cast<std::int32_t>(context_.value(kRow<0x60FF>))) +
                         static_cast<float>(static_cast<std::int32_t>(context_.value(kRow<0x60B1>)));
    // Rounded to whole user units per second: four halves of them in a second difference.
    const float rounding =
        2.0F * approx::absolute(context_.velocity_in_ticks(1.0F)) * stream().clock().period_ticks();
    path_.set_limits(stream().path_limits(controller.motion_limits(), controller.range(), rounding));
    stream().sync_velocity(controller.ticks(), has_target, context_.velocity_in_ticks(wanted), path_,
                           Ahead{controller});
  }

  CyclicPosition& stream() { return context_.controller.cyclic_position(); }

  // 60C2h: value x 10^index seconds.
  float period_s() const {
    float seconds = static_cast<float>(context_.value(kRow<0x60C2, 1>));
    for (auto power = static_cast<std::int32_t>(context_.value(kRow<0x60C2, 2>)); power < 0; ++power)
      seconds *= 0.1F;
    return seconds;
  }

  ProfileContext& context_;
  StreamPath path_;
  Mode streamed_ = Mode::kNone;  // the reference is the stream's, or waits for it
  bool target_written_ = false;  // since the last SYNC
  bool target_holds_ = false;
  bool target_streamed_ = false;  // by a PDO with SYNC
};

}  // namespace slipstack::canopen
