// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "firmware/control/bounds/position_range.h"
#include "firmware/control/reference/fixed_motion.h"
#include "firmware/control/reference/motion_limits.h"
#include "firmware/control/reference/reference.h"
#include "firmware/control/reference/trajectory.h"

namespace slipstack {

enum class PlanStatus : std::uint8_t {
  kOk,
  kBadLimits,    ///< a limit is not positive, or beyond kLargestRate
  kTooSlow,      ///< a ramp longer than 2^22 ticks: beyond that its sums would show
  kBeyondRange,  ///< from this motion the axis would leave its range before it arrives: brake first
  kBusy,         ///< the tick was faster than the plan, three times: try again
};

/// Moves to a target, changes of velocity and halts, time-optimal within their limits, from whatever state
/// the reference is in.
/// Works in the main loop; the tick takes over what was planned (ReferenceGenerator). A plan costs at most
/// 30 evaluations of a stopping distance in double (trajectory.h; figures in docs/control.md). Holds its
/// working memory; not for the stack.
class PointToPoint {
 public:
  /// Retargets the reference to `target`, where it ends exactly. Positions count from `origin`, and a way is
  /// not taken modulo 2^32: from -2^31 to 2^31 - 1 it is 2^32 counts long.
  PlanStatus move(ReferenceGenerator& reference, std::int32_t target, const MotionLimits& limits,
                  const BrakingLimits& braking, const PositionRange& range = {}, std::int32_t origin = 0) {
    return plan(reference, {.kind = Goal::Kind::kPlace, .place = target, .origin = origin}, limits, braking,
                range);
  }
  /// Changes the velocity to this one, counts per tick, and keeps it until something else is commanded, or
  /// rests at the end of the range. Counts go on modulo 2^32: without an end of the range it never ends.
  PlanStatus run(ReferenceGenerator& reference, float velocity, const MotionLimits& limits,
                 const BrakingLimits& braking, const PositionRange& range = {}) {
    if (velocity == 0.0F) return plan(reference, {}, limits, braking, range);
    const bool forward = velocity > 0.0F;
    const std::int32_t end = forward ? range.highest : range.lowest;
    const bool endless = end == (forward ? PositionRange::kNoHighest : PositionRange::kNoLowest);
    MotionLimits narrowed = limits;
    narrowed.velocity = std::min(limits.velocity, forward ? velocity : -velocity);
    return plan(reference,
                {.kind = endless ? Goal::Kind::kVelocity : Goal::Kind::kEnd,
                 .place = end,
                 .direction = forward ? 1.0 : -1.0},
                narrowed, braking, range);
  }
  /// Moves in this direction (1 or -1) until something else is commanded, 2^31 counts at the most.
  PlanStatus search(ReferenceGenerator& reference, std::int32_t direction, const MotionLimits& limits,
                    const BrakingLimits& braking) {
    constexpr std::int32_t kFarthest = 0x7FFFFFFF;
    const std::int32_t from = reference.counts();
    return move(reference, sum(from, direction * kFarthest), limits, braking, {}, from);
  }
  /// Brakes to rest as fast as the limits allow.
  PlanStatus halt(ReferenceGenerator& reference, const MotionLimits& limits, const BrakingLimits& braking) {
    return plan(reference, {}, limits, braking, {});
  }

 private:
  // Where a plan leads.
  struct Goal {
    enum class Kind : std::uint8_t {
      kRest,      // wherever
      kPlace,     // rest there
      kEnd,       // the same, of a range: not to be passed, nor returned to
      kVelocity,  // the largest one in this direction
    };
    Kind kind = Kind::kRest;
    std::int32_t place = 0;
    std::int32_t origin = 0;  // positions count from there
    double direction = 1.0;
  };
  static constexpr double kUnit = 0x1p44;
  static constexpr double kLongestRamp = 0x1p22;
  static constexpr std::int64_t kEndless_ticks = std::int64_t{1} << 62;
  static constexpr std::uint32_t kShortestLead = 32;
  static constexpr std::uint32_t kLongestLead = 512;

  static bool valid(float limit) { return limit > 0.0F && limit <= kLargestRate; }

  // Not inlined: double stays here (tests/budget/check_double.py).
  [[gnu::noinline]] PlanStatus plan(ReferenceGenerator& reference, const Goal& goal,
                                    const MotionLimits& wanted, const BrakingLimits& braking,
                                    const PositionRange& range) {
    if (!valid(wanted.velocity) || !valid(wanted.acceleration) || !valid(wanted.deceleration) ||
        !valid(wanted.jerk)) {
      return PlanStatus::kBadLimits;
    }
    const trajectory::Limits limits{on_grid(wanted.velocity), static_cast<double>(wanted.acceleration),
                                    static_cast<double>(wanted.deceleration),
                                    static_cast<double>(wanted.jerk)};
    for (int attempt = 0; attempt < 3; ++attempt) {
      const ReferenceGenerator::Prediction from = reference.predict(lead_, braking);
      const trajectory::Profile& profile = course(from.motion, goal, limits);
      if (longest_ramp(profile) > kLongestRamp) return PlanStatus::kTooSlow;
      if (leaves(range, profile, from.motion)) return PlanStatus::kBeyondRange;
      write(profile, from.motion, goal, reference.spare_plan());
      if (reference.arm(from)) return PlanStatus::kOk;
      lead_ = std::min(2 * lead_, kLongestLead);
    }
    return PlanStatus::kBusy;
  }

  const trajectory::Profile& course(const Motion& from, const Goal& goal, const trajectory::Limits& limits) {
    const trajectory::State state = state_of(from);
    switch (goal.kind) {
      case Goal::Kind::kPlace:
        return planner_.move(state, way(from, goal.place, goal.origin), limits);
      case Goal::Kind::kEnd:
        return planner_.approach(state, way(from, goal.place, goal.origin), goal.direction, limits);
      case Goal::Kind::kVelocity:
        return planner_.change(state, goal.direction * limits.velocity, limits);
      default:
        return planner_.stop(state, limits);
    }
  }

  // So that any number of ticks of it is exact in the tick's sums, as the plan takes it to be.
  static double on_grid(float velocity) {
    const double exact = static_cast<double>(to_fixed(velocity)) * (1.0 / kUnit);
    return exact > 0.0 ? exact : 1.0 / kUnit;
  }

  // Sums to instants: the inverse of what write() does. The position counts from the whole count.
  static trajectory::State state_of(const Motion& motion) {
    const double fine = 1.0 / kUnit / static_cast<double>(std::int64_t{1} << motion.shift);
    const double jerk = static_cast<double>(motion.jerk) * fine;
    const double acceleration = static_cast<double>(motion.acceleration) * fine + jerk;
    const double velocity = static_cast<double>(motion.velocity) * (1.0 / kUnit);
    return {0.0, velocity + 0.5 * acceleration - jerk * (1.0 / 6.0), acceleration};
  }

  static double way(const Motion& motion, std::int32_t target, std::int32_t origin) {
    const std::int64_t counts =
        static_cast<std::int64_t>(difference(target, origin)) - difference(motion.counts, origin);
    return static_cast<double>(counts) - static_cast<double>(motion.fraction) * (1.0 / kUnit);
  }

  // Beyond an end of the range, and beyond where it begins.
  static bool leaves(const PositionRange& range, const trajectory::Profile& profile, const Motion& from) {
    const trajectory::Extent extent = trajectory::extent(profile);
    const bool high = range.highest != PositionRange::kNoHighest && extent.highest > 0.5 &&
                      extent.highest > way(from, range.highest, 0) + 0.5;
    const bool low = range.lowest != PositionRange::kNoLowest && extent.lowest < -0.5 &&
                     extent.lowest < way(from, range.lowest, 0) - 0.5;
    return high || low;
  }

  static double longest_ramp(const trajectory::Profile& profile) {
    double longest = 0.0;
    for (std::size_t i = 0; i < profile.size(); ++i) {
      const bool cruise = profile[i].jerk == 0.0 && profile[i].begin.acceleration == 0.0;
      if (!cruise) longest = std::max(longest, profile[i].ticks);
    }
    return longest;
  }

  static std::int64_t round_up(double ticks) {
    const auto whole = static_cast<std::int64_t>(ticks);
    return whole + (static_cast<double>(whole) < ticks ? 1 : 0);
  }

  // Binary places that the acceleration has to spare.
  static std::int32_t shift_for(const trajectory::Profile& profile) {
    double largest = 0.0;
    for (std::size_t i = 0; i < profile.size(); ++i) {
      const double a = profile[i].begin.acceleration;
      const double j = profile[i].jerk;
      largest = std::max({largest, a < 0.0 ? -a : a, j < 0.0 ? -j : j});
    }
    std::int32_t shift = 0;
    for (; shift < kLargestShift && largest < 0x1p16; ++shift) largest *= 2.0;
    return shift;
  }

  // Instants to sums: each segment begins at the first tick of its phase, at the place where the phase is
  // then. Sums that pass the cubic x + V m + A m^2 / 2 + J m^3 / 6 at every tick m begin with V - A / 2 + J /
  // 6 and A - J.
  static void write(const trajectory::Profile& profile, const Motion& from, const Goal& goal,
                    MotionPlan& plan) {
    const std::int32_t shift = shift_for(profile);
    const double fine = kUnit * static_cast<double>(std::int64_t{1} << shift);
    plan.size = 0;
    double begin_ticks = 0.0;
    for (std::size_t i = 0; i < profile.size(); ++i) {
      const trajectory::Phase& phase = profile[i];
      const std::int64_t first = round_up(begin_ticks);
      const double offset = static_cast<double>(first) - begin_ticks;
      begin_ticks += phase.ticks;
      const std::int64_t ticks = round_up(begin_ticks) - first;
      if (ticks <= 0) continue;
      const trajectory::State at = trajectory::after(phase.begin, phase.jerk, offset);
      MotionSegment& segment = plan.segments[plan.size++];
      segment.ticks = ticks;
      set_position(segment, from, at.position);
      segment.velocity =
          static_cast<std::int64_t>((at.velocity - 0.5 * at.acceleration + phase.jerk * (1.0 / 6.0)) * kUnit);
      segment.acceleration = static_cast<std::int64_t>((at.acceleration - phase.jerk) * fine);
      segment.jerk = static_cast<std::int64_t>(phase.jerk * fine);
      segment.shift = shift;
    }
    MotionSegment& last = plan.segments[plan.size++];
    last = {.ticks = 1, .sets_position = true};
    const trajectory::State& end = profile.end();
    if (goal.kind == Goal::Kind::kVelocity) {
      last.ticks = kEndless_ticks;
      last.velocity = static_cast<std::int64_t>(end.velocity * kUnit);
      const double offset = static_cast<double>(round_up(begin_ticks)) - begin_ticks;
      return set_position(last, from, end.position + offset * end.velocity);
    }
    set_position(last, from, end.position);
    if (!arrives(end.position, from, goal)) return;
    last.start_counts = goal.place;
    last.start_fraction = 0;
  }

  // A course to the end of a range may end before it.
  static bool arrives(double position, const Motion& from, const Goal& goal) {
    if (goal.kind == Goal::Kind::kRest) return false;
    const double off = position - way(from, goal.place, goal.origin);
    return goal.kind == Goal::Kind::kPlace || (off < 0.5 && off > -0.5);
  }

  static void set_position(MotionSegment& segment, const Motion& from, double moved) {
    auto whole = static_cast<std::int64_t>(moved);
    if (static_cast<double>(whole) > moved) --whole;
    const std::int64_t fraction =
        from.fraction + static_cast<std::int64_t>((moved - static_cast<double>(whole)) * kUnit);
    segment.start_counts = static_cast<std::int32_t>(
        static_cast<std::uint32_t>(from.counts) +
        static_cast<std::uint32_t>(static_cast<std::uint64_t>(whole + (fraction >> kFractionBits))));
    segment.start_fraction = fraction & ((std::int64_t{1} << kFractionBits) - 1);
    segment.sets_position = true;
  }

  trajectory::Planner planner_;
  std::uint32_t lead_ = kShortestLead;
};

}  // namespace slipstack
