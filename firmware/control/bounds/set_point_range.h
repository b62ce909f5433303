// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/bounds/position_range.h"
#include "firmware/effects/approx.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// Set-points of a stream within a position range: towards an end of it never faster than they can still come
/// to rest there, and never beyond. In the main loop.
///
/// With A counts per period^2 of deceleration, s counts in this period and s - A, s - 2 A, ... in the next
/// ones take s (s / A + 1) / 2 to rest; within the room e that is left, s <= sqrt(A^2 / 4 + 2 A e) - A / 2.
class SetPointRange {
 public:
  /// `deceleration`: counts per period^2, > 0.
  void set(const PositionRange& range, float deceleration) {
    range_ = range;
    deceleration_ = deceleration;
  }
  void reset() { known_ = limited_ = false; }

  /// The set-point of this period, `wanted` or as far as the range allows.
  std::int32_t within(std::uint32_t period, std::int32_t wanted) {
    if (!known_) {
      last_ = range_.nearest(wanted);
    } else {
      const bool forward = difference(wanted, last_) > 0;
      const auto way = static_cast<float>(difference(wanted, last_));
      const float most = farthest(range_.room(last_, forward), period - last_period_);
      limited_ = approx::absolute(way) > most;
      const float allowed = forward ? most : -most;
      last_ = limited_ ? sum(last_, static_cast<std::int32_t>(allowed)) : wanted;
    }
    if (!known_) limited_ = last_ != wanted;
    known_ = true;
    last_period_ = period;
    return last_;
  }

  /// The last one was held back.
  bool limited() const { return limited_; }

  /// Counts that a set-point may lie beyond the one before, with so many left to the end.
  static float farthest(float room, float deceleration) {
    const float half = 0.5F * deceleration;
    const float way = approx::fast_square_root(half * half + 4.0F * half * room) - half;
    return way < room ? way : room;
  }

 private:
  float farthest(float room, std::uint32_t periods) const {
    const float n = periods == 0 || periods > 1000 ? 1.0F : static_cast<float>(periods);
    return farthest(room, deceleration_ * n * n);
  }

  PositionRange range_;
  float deceleration_ = 1.0F;
  std::int32_t last_ = 0;
  std::uint32_t last_period_ = 0;
  bool known_ = false;
  bool limited_ = false;
};

}  // namespace slipstack
