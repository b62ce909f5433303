// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/effects/numerics/approx.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// Which period a set-point belongs to, in the main loop.
///
/// SYNC n at time n, give or take half a period: n. Otherwise time alone does not tell a SYNC that is late by
/// a period from the one after a SYNC that was lost, nor one of several that were held back and come at once.
/// The set-points do: of the periods between the last one and the present, it belongs to that whose place on
/// the parabola through the last three is nearest. Where the axis hardly moves that makes no difference, and
/// time decides. It decides, too, when it has been ahead three times in a row by the same: then the master
/// has lost time of its own.
class SetPointPeriods {
 public:
  struct Place {
    std::uint32_t period = 0;
    std::int32_t counts = 0;
  };

  void reset() { known_ = 0; }

  /// `by_time`: the period that it is. `reach`: counts that the axis may move in a period; a set-point beyond
  /// is taken as far as that.
  Place place(std::uint32_t by_time, std::int32_t target, std::int32_t reach) {
    const auto since = static_cast<std::int32_t>(by_time - last_.period);
    if (known_ == 0 || since > kFarthest || since < -kFarthest) return begin(by_time, target);
    std::int32_t ahead = since;
    if (since != 1 && known_ > 2) ahead = nearest(since, target);
    stuck_ = ahead != since && since == last_since_ ? stuck_ + 1 : 0;
    last_since_ = since;
    if (stuck_ >= kStuck) return begin(by_time, target);
    if (ahead < 0) ahead = 0;
    const std::int32_t way = limited(difference(target, last_.counts), reach * (ahead > 1 ? ahead : 1));
    last_ = {last_.period + static_cast<std::uint32_t>(ahead), sum(last_.counts, way)};
    if (ahead > 0) learn(static_cast<float>(way), static_cast<float>(ahead));
    ++known_;
    return last_;
  }

 private:
  static constexpr std::int32_t kFarthest = 5;
  static constexpr std::int32_t kStuck = 2;
  static constexpr float kSame_counts = 2.0F;  ///< rounding of two set-points, and of what they predict

  static std::int32_t limited(std::int32_t way, std::int32_t largest) {
    return way > largest ? largest : (way < -largest ? -largest : way);
  }

  Place begin(std::uint32_t period, std::int32_t target) {
    last_ = {period, target};
    known_ = 1;
    stuck_ = last_since_ = 0;
    velocity_ = acceleration_ = 0.0F;
    return last_;
  }

  // The last set-point lies `way` beyond the one `periods` before it.
  void learn(float way, float periods) {
    const float mean = way / periods;
    // Velocities half of the way back lie (periods + 1) / 2 apart, as long as single periods are the rule.
    acceleration_ = (mean - velocity_) / (0.5F * (periods + 1.0F));
    velocity_ = mean;
  }

  // Periods after the last set-point. Another than time's must be nearer by far.
  std::int32_t nearest(std::int32_t since, std::int32_t target) const {
    const auto way = static_cast<float>(difference(target, last_.counts));
    const auto off = [&](std::int32_t ahead) {
      const auto n = static_cast<float>(ahead);
      return approx::absolute(way - n * velocity_ - 0.5F * n * (n + 1.0F) * acceleration_);
    };
    const std::int32_t by_time = since < 0 ? 0 : since;
    std::int32_t best = by_time;
    float smallest = 0.25F * off(by_time) - kSame_counts;
    for (std::int32_t ahead = 0; ahead <= (since < 1 ? 1 : since); ++ahead) {
      if (off(ahead) >= smallest) continue;
      smallest = off(ahead);
      best = ahead;
    }
    return best;
  }

  Place last_;
  float velocity_ = 0.0F;      // counts per period, over the last one
  float acceleration_ = 0.0F;  // counts per period^2
  std::int32_t known_ = 0;
  std::int32_t last_since_ = 0;
  std::int32_t stuck_ = 0;
};

}  // namespace slipstack
