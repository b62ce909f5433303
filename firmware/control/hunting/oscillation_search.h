// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/effects/numerics/approx.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// Finds a sustained oscillation in encoder counts. A limit cycle repeats itself, noise and disturbances do
/// not: an oscillation is regular where the standard deviation of its periods is below a third of their mean
/// (Thornhill, Huang, Zhang: Detection of multiple oscillations in control loops, J. Process Control 13(1)
/// 2003). The same is asked of the swings, since a resonance that noise excites has regular periods, and
/// swings that are those of a Rayleigh distribution, with a ratio of 0.52. Both with four standard errors to
/// spare, so that few periods must be the more regular; and the swings must not die away.
///
/// Periods lie between turning points, which need no mean and no filter. They are judged together once there
/// are eight of them and half a second; then the next ones.
///
/// O(1) per tick.
class OscillationSearch {
 public:
  struct Settings {
    std::int32_t least_counts = 1;    ///< a swing is larger
    std::int32_t shortest_ticks = 8;  ///< mean period
    std::int32_t longest_ticks = 0;   ///< of a period
    std::int32_t least_ticks = 0;     ///< that are judged together
  };
  static constexpr int kFewest = 8;  ///< periods that are judged together

  /// Forgets what was seen, but what was found last.
  void begin() {
    const Found found = found_;
    *this = {};
    found_ = found;
  }

  /// One tick: true where the periods that it ends are those of an oscillation.
  bool step(const Settings& settings, std::int32_t counts) {
    if (!begun_) {
      begun_ = true;
      turned_at_ = extreme_ = counts;
    }
    if (++since_ > settings.longest_ticks) sums_ = {};
    turned_ = false;
    const std::int32_t beyond = difference(counts, extreme_);
    if (rises_ ? beyond >= 0 : beyond <= 0) {
      extreme_ = counts;
      return false;
    }
    if ((rises_ ? -beyond : beyond) <= settings.least_counts) return false;
    const auto size = static_cast<float>(difference(extreme_, turned_at_));
    turned_ = true;
    turned_at_ = extreme_;
    extreme_ = counts;
    rises_ = !rises_;
    if (rises_) return end_period(settings, size);
    last_rise_ = size;
    return false;
  }

  /// The last step() was at a turning point.
  bool turned() const { return turned_; }

  /// Of the oscillation that was found last.
  struct Found {
    float period_ticks = 0.0F;
    float swing_counts = 0.0F;  ///< from turning point to turning point
    std::int32_t ticks = 0;     ///< that were judged
  };
  const Found& found() const { return found_; }

 private:
  struct Sums {
    float number = 0.0F;
    float period = 0.0F, period_squares = 0.0F;
    float size = 0.0F, size_squares = 0.0F;
    float later = 0.0F;  // of the sizes, times their number
  };

  // A rise and the fall that has just ended.
  bool end_period(const Settings& settings, float fall) {
    const auto period = static_cast<float>(since_);
    const float size = 0.5F * (last_rise_ - fall);
    const bool whole = since_ <= settings.longest_ticks && ended_one_;
    since_ = 0;
    ended_one_ = true;
    if (!whole) return false;
    sums_.later += sums_.number * size;
    sums_.number += 1.0F;
    sums_.period += period;
    sums_.period_squares += period * period;
    sums_.size += size;
    sums_.size_squares += size * size;
    if (sums_.number < kFewest || sums_.period < static_cast<float>(settings.least_ticks)) return false;
    const Sums judged = sums_;
    sums_ = {};
    const bool found = judged.period >= judged.number * static_cast<float>(settings.shortest_ticks) &&
                       regular(judged.number, judged.period, judged.period_squares) &&
                       regular(judged.number, judged.size, judged.size_squares) && stays(judged);
    if (found) {
      found_ = {judged.period / judged.number, judged.size / judged.number,
                static_cast<std::int32_t>(judged.period)};
    }
    return found;
  }

  // The standard error of a standard deviation is 1 / sqrt(2 n) of it, for a normal distribution.
  static bool regular(float number, float sum, float squares) {
    const float variance = number * squares / (sum * sum) - 1.0F;  // over the square of the mean
    const float upper = 1.0F + 4.0F * approx::fast_square_root(0.5F / number);
    return 9.0F * variance * upper * upper <= 1.0F;
  }

  // The line through the sizes loses less than a fifth of their mean from its begin to its end. Its slope is
  // 12 / (n^3 - n) times the sum of (i - (n - 1) / 2) size.
  static bool stays(const Sums& of) {
    const float n = of.number;
    const float moment = of.later - 0.5F * (n - 1.0F) * of.size;
    const float change = 12.0F * moment / (n * (n + 1.0F));
    return change > -0.2F * of.size / n;
  }

  Sums sums_;
  Found found_;
  float last_rise_ = 0.0F;
  std::int32_t turned_at_ = 0;  // the last turning point
  std::int32_t extreme_ = 0;    // since
  std::int32_t since_ = 0;      // ticks since the last period
  bool rises_ = true;
  bool ended_one_ = false;
  bool begun_ = false;
  bool turned_ = false;
};

}  // namespace slipstack
