// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/canopen/profile/profile_context.h"

namespace slipstack::canopen {

/// What objects bound motion by (607Dh, 607Fh, 6080h, 6084h, 6085h, 60A4h, 60C5h, 60C6h, times of the
/// brake), to the tick. Positions bound where they are referenced, and homing looks for the switches that
/// bound otherwise.
class BoundsProfile {
 public:
  explicit BoundsProfile(const ProfileContext& context) : context_(context) {}

  /// An object or a unit has changed.
  void changed() { changed_ = true; }

  /// In every pass of the main loop; true when the tick got other bounds.
  bool step() {
    const bool homing = context_.mode == Mode::kHoming;
    const PositionReference& place = context_.controller.position();
    const bool ranged = place.referenced() && !homing;
    if (ranged != ranged_ || homing == switches_ || place.origin() != range_origin_) changed_ = true;
    if (!changed_) return false;
    changed_ = false;
    ranged_ = ranged;
    switches_ = !homing;
    range_origin_ = place.origin();
    context_.controller.bound(bounds());
    return true;
  }

 private:
  UserBounds bounds() const {
    const auto real = [this](std::size_t row) { return static_cast<float>(context_.value(row)); };
    UserBounds user;
    if (ranged_) user.range = software_limits();
    user.switches = switches_;
    user.velocity_mps = real(kRow<0x6080>) * 1e-3F;
    user.profile_velocity_counts_per_s = in_counts(kRow<0x607F>);
    user.acceleration_counts_per_s2 = in_counts(kRow<0x60C5>);
    user.deceleration_counts_per_s2 = in_counts(kRow<0x60C6>);
    user.quick_stop_counts_per_s2 = in_counts(kRow<0x6085>);
    user.slow_down_counts_per_s2 = in_counts(kRow<0x6084>);
    user.slow_down_counts_per_s3 = in_counts(kRow<0x60A4, 1>);
    user.brake_release_s = real(kRow<kBrakeIndex, 1>) * 1e-3F;
    user.brake_apply_s = real(kRow<kBrakeIndex, 2>) * 1e-3F;
    return user;
  }

  // As delivered nothing is bounded, whatever the user's unit is.
  float in_counts(std::size_t row) const {
    const std::uint32_t value = context_.value(row);
    if (value == 0xFFFFFFFFU) return UserBounds::kNone;
    return static_cast<float>(value) * context_.units.counts_per_user();
  }

  // 607Dh in counts; the last number there is bounds nothing.
  PositionRange software_limits() const {
    constexpr std::int32_t kMin = PositionRange::kNoLowest;
    constexpr std::int32_t kMax = PositionRange::kNoHighest;
    const std::optional<std::int32_t> first = range_end(kRow<0x607D, 1>, kMin);
    const std::optional<std::int32_t> second = range_end(kRow<0x607D, 2>, kMax);
    if (context_.units.turned()) return {second.value_or(kMin), first.value_or(kMax)};
    return {first.value_or(kMin), second.value_or(kMax)};
  }
  std::optional<std::int32_t> range_end(std::size_t row, std::int32_t none) const {
    const auto end = static_cast<std::int32_t>(context_.value(row));
    const std::optional<std::int32_t> from_zero = context_.units.to_counts(end);
    if (end == none || !from_zero) return std::nullopt;
    const std::int64_t counts = std::int64_t{*from_zero} + range_origin_;
    if (counts != static_cast<std::int32_t>(counts)) return std::nullopt;
    return static_cast<std::int32_t>(counts);
  }

  const ProfileContext& context_;
  bool changed_ = false;
  bool ranged_ = false;  // as the bounds were given last
  bool switches_ = true;
  std::int32_t range_origin_ = 0;
};

}  // namespace slipstack::canopen
