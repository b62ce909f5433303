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

// distance x 2^44 / product, both positive, product < 2^50: long division in two steps.
inline std::int64_t jerk_for(std::uint32_t distance, std::uint64_t product) {
  const std::uint64_t head = static_cast<std::uint64_t>(distance) << 32;
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
/// Boerlage, Steinbuch, Control Engineering Practice 13 (2005), third order. Not for the tick.
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

/// Set-points that arrive every `period` ticks, joined by a cubic B-spline (de Boor, A Practical Guide to
/// Splines, chapter 9): position, velocity and acceleration are continuous, so that a stream asks no steps of
/// the current. The spline's control points are c = p - (p_next - 2 p + p_before) / 6; it passes the
/// set-points to within a 36th of their fourth difference. Three periods of delay: after the last set-point,
/// send it three times more.
class SetpointStream {
 public:
  static constexpr std::int32_t kLongestPeriod = 100;

  /// Starts from rest at the generator's position; a set-point every 1 to kLongestPeriod ticks.
  void start(const ReferenceGenerator& generator, std::int32_t period_ticks) {
    origin_ = generator.counts();
    last_ = before_ = 0;
    control_ = {};
    period_ = period_ticks < 1 ? 1 : (period_ticks > kLongestPeriod ? kLongestPeriod : period_ticks);
  }

  /// Takes a set-point, counts and a fraction of 2^-32, and queues a segment of one period. False when there
  /// is no room or the set-points lie 2^12 counts per tick or more apart. Outside the tick.
  bool push(ReferenceGenerator& generator, std::int32_t counts, std::uint32_t fraction = 0) {
    const std::int64_t n = period_;
    // 2^36 per count: what is lost is below 10^-5 count after the longest period, and products fit.
    const std::int64_t next = static_cast<std::int64_t>(difference(counts, origin_)) * kUnit +
                              (static_cast<std::int64_t>(fraction) << 4);
    const std::int64_t largest = n * (kUnit << 12);
    if (generator.free() == 0 || next - last_ >= largest || next - last_ <= -largest) return false;
    const std::int64_t newest = last_ - (next - 2 * last_ + before_) / 6;
    const auto [c0, c1, c2] = control_;
    // The cubic x0 + V m + A m^2 / 2 + J m^3 / 6 over ticks m, and the sums of the generator that pass
    // through it.
    const std::int64_t jerk = (newest - 3 * c2 + 3 * c1 - c0) / (n * n * n);
    const std::int64_t acceleration = (c2 - 2 * c1 + c0) / (n * n);
    const std::int64_t velocity = (c2 - c0) / (2 * n);
    const std::int64_t start = (c0 + 4 * c1 + c2) / 6;
    constexpr std::int64_t kFine = std::int64_t{1} << (kFractionBits - kUnitBits);
    const MotionSegment segment{.ticks = period_,
                                .start_counts = sum(origin_, static_cast<std::int32_t>(start >> kUnitBits)),
                                .start_fraction = (start & (kUnit - 1)) * kFine,
                                .velocity = (velocity - acceleration / 2 + jerk / 6) * kFine,
                                .acceleration = (acceleration - jerk) * kFine,
                                .jerk = jerk * kFine,
                                .sets_position = true};
    if (!generator.push(segment)) return false;
    // The origin follows, so that differences stay small however far the stream goes.
    const auto moved = static_cast<std::int32_t>(last_ >> kUnitBits);
    const std::int64_t shift = moved * kUnit;
    origin_ = sum(origin_, moved);
    control_ = {c1 - shift, c2 - shift, newest - shift};
    before_ = last_ - shift;
    last_ = next - shift;
    return true;
  }

 private:
  static constexpr int kUnitBits = 36;
  static constexpr std::int64_t kUnit = std::int64_t{1} << kUnitBits;

  std::int32_t origin_ = 0;
  std::int32_t period_ = 1;
  std::int64_t before_ = 0;  // set-points, relative to the origin
  std::int64_t last_ = 0;
  std::array<std::int64_t, 3> control_{};  // oldest first
};

}  // namespace slipstack
