// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/reference.h"
#include "firmware/effects/approx.h"

namespace slipstack {

/// Limits of a move, in counts and ticks.
struct MotionLimits {
  float velocity = 0.0F;      ///< counts per tick
  float acceleration = 0.0F;  ///< counts per tick^2
  float jerk = 0.0F;          ///< counts per tick^3
};

enum class PlanStatus : std::uint8_t {
  kOk,
  kNothingToDo,  ///< start and target are the same
  kBadLimits,    ///< a limit is not positive and finite
  kTooLong,      ///< farther than 2^27 counts, or longer than 2^20 ticks
  kBusy,         ///< no room in the queue, or the axis still moves
};

namespace detail {

// Durations of the three averages of a jerk-limited move; see plan_move.
struct MoveTimes {
  std::int32_t jerk, acceleration, cruise;
};

inline std::int32_t round_up(float ticks) {
  const std::int32_t whole = static_cast<std::int32_t>(ticks);
  return whole + (static_cast<float>(whole) < ticks ? 1 : 0) + (whole < 1 && ticks <= 0.0F ? 1 : 0);
}

inline MoveTimes move_times(float distance, const MotionLimits& limits) {
  float t1 = limits.acceleration / limits.jerk;
  float t2 = limits.velocity / limits.acceleration;
  if (t1 > t2) t1 = t2 = approx::square_root(limits.velocity / limits.jerk);
  float t3 = distance / limits.velocity;
  if (t3 < t1 + t2) {  // the velocity limit is not reached
    t1 = limits.acceleration / limits.jerk;
    t2 = 0.5F * (approx::square_root(t1 * t1 + 4.0F * distance / limits.acceleration) - t1);
    if (t2 < t1) t1 = t2 = approx::power(0.5F * distance / limits.jerk, 1.0F / 3.0F);
    t3 = t1 + t2;
  }
  const std::int32_t n1 = round_up(t1), n2 = round_up(t2), n3 = round_up(t3);
  const std::int32_t longer = n2 > n1 ? n2 : n1;
  return {n1, longer, n3 > n1 + longer ? n3 : n1 + longer};
}

// distance x 2^48 / product, both positive, product < 2^50: long division in two steps.
inline std::int64_t jerk_for(std::uint32_t distance, std::uint64_t product) {
  const std::uint64_t head = static_cast<std::uint64_t>(distance) << 36;
  const std::uint64_t rest = (head % product) << 12;
  return static_cast<std::int64_t>(((head / product) << 12) + rest / product);
}

}  // namespace detail

/// Queues a move from rest at the generator's position to `target_counts`, in the shortest time within the
/// limits, durations rounded up to ticks.
///
/// A jerk-limited move is a step averaged three times, over n1, n2 and n3 >= n1 + n2 ticks: peak velocity
/// distance / n3, peak acceleration that / n2, jerk that / n1. With whole numbers of ticks the sums are
/// exact; the remainder of the division, below 2^-8 of a count, is taken out at the end. Shape: Lambrechts,
/// Boerlage, Steinbuch, Control Engineering Practice 13 (2005), third order. Not for the tick: about 2000
/// instructions.
inline PlanStatus plan_move(ReferenceGenerator& generator, std::int32_t target_counts,
                            const MotionLimits& limits) {
  const auto positive = [](float value) { return value > 0.0F && value < 1e9F; };
  if (!positive(limits.velocity) || !positive(limits.acceleration) || !positive(limits.jerk)) {
    return PlanStatus::kBadLimits;
  }
  if (!generator.idle() || generator.free() < 8) return PlanStatus::kBusy;
  const std::int32_t distance = difference(target_counts, generator.counts());
  if (distance == 0) return PlanStatus::kNothingToDo;
  const bool back = distance < 0;
  const std::uint32_t way =
      back ? 0U - static_cast<std::uint32_t>(distance) : static_cast<std::uint32_t>(distance);
  if (way >= (1U << 27)) return PlanStatus::kTooLong;
  // Counted in float so that too long a move is seen before it overflows.
  const float slowest = static_cast<float>(way) / limits.velocity + limits.velocity / limits.acceleration +
                        limits.acceleration / limits.jerk;
  if (!(slowest < 0x1p20F)) return PlanStatus::kTooLong;
  const auto [n1, n2, n3] = detail::move_times(static_cast<float>(way), limits);
  const auto product =
      static_cast<std::uint64_t>(n1) * static_cast<std::uint64_t>(n2) * static_cast<std::uint64_t>(n3);
  if (product >= (std::uint64_t{1} << 50)) return PlanStatus::kTooLong;
  const std::int64_t jerk = detail::jerk_for(way, product) * (back ? -1 : 1);
  const std::array<std::int32_t, 7> ticks = {n1, n2 - n1, n1, n3 - n2 - n1, n1, n2 - n1, n1};
  const std::array<std::int32_t, 7> sign = {1, 0, -1, 0, -1, 0, 1};
  MotionSegment segment;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    segment.ticks = ticks[i];
    segment.jerk = jerk * sign[i];
    if (ticks[i] > 0) generator.push(segment);
    segment = after(segment);
  }
  generator.push({.ticks = 1, .start_counts = target_counts, .sets_position = true});
  return PlanStatus::kOk;
}

/// Set-points that arrive every `period` ticks, joined by cubics: position and velocity are continuous, the
/// velocity at each set-point is the mean over the period before it. One period of delay.
class SetpointStream {
 public:
  /// Starts from rest at the generator's position; a set-point every 1 to 1000 ticks.
  void start(const ReferenceGenerator& generator, std::int32_t period_ticks) {
    last_counts_ = generator.counts();
    velocity_ = 0;
    period_ = period_ticks < 1 ? 1 : (period_ticks > 1000 ? 1000 : period_ticks);
  }

  /// Queues the cubic from the last set-point to this one; false when there is no room or the set-points lie
  /// 2^12 counts per tick or more apart. About 500 instructions, outside the tick.
  bool push(ReferenceGenerator& generator, std::int32_t counts) {
    const std::int64_t n = period_;
    const std::int64_t way = difference(counts, last_counts_);
    if (generator.free() == 0 || way >= n << 12 || way <= -(n << 12)) return false;
    // 2^24 per count: what is lost is below 0.03 count after 1000 ticks, and products fit.
    const std::int64_t whole = way * (std::int64_t{1} << 24);
    const std::int64_t mean = whole / n;
    // Third differences j and a of the sums that reach `way` and the mean velocity after n ticks:
    //   n a + j n (n + 1) / 2 = v1 - v0,   n v0 + a n (n + 1) / 2 + j n (n + 1) (n + 2) / 6 = way.
    const std::int64_t v0 = velocity_ >> 24;
    std::int64_t a = 0;
    std::int64_t j = 0;
    if (n > 1) {
      j = (12 * ((v0 + mean) * n - 2 * whole) + 12 * (mean - v0)) / (2 * n * (n * n - 1));
      a = (mean - v0) / n - j * (n + 1) / 2;
    }
    MotionSegment segment{.ticks = period_,
                          .start_counts = last_counts_,
                          .velocity = velocity_,
                          .acceleration = a * (std::int64_t{1} << 24),
                          .jerk = j * (std::int64_t{1} << 24),
                          .sets_position = true};
    if (n == 1) segment.velocity = way * (std::int64_t{1} << kFractionBits);
    if (!generator.push(segment)) return false;
    last_counts_ = counts;
    velocity_ = mean * (std::int64_t{1} << 24);
    return true;
  }

 private:
  std::int32_t last_counts_ = 0;
  std::int32_t period_ = 1;
  std::int64_t velocity_ = 0;
};

}  // namespace slipstack
