// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/bounds/position_range.h"
#include "firmware/control/bounds/stopping_distance.h"
#include "firmware/control/streams/set_point_spline.h"

namespace slipstack {

/// The path that a stream of set-points leads the reference on: a uniform cubic B-spline, one control point a
/// period. It begins in whatever state the reference has, and goes where the stream goes as far as velocity,
/// acceleration, jerk and the range allow: a stream that asks for more is met again as fast as they allow.
///
/// The steps v between its control points c, their differences a and the differences of those are velocity,
/// acceleration and jerk of the path: the velocity is the quadratic B-spline of v, the acceleration runs in
/// straight lines through a, and all lie within the hull of their control points (de Boor, A Practical Guide
/// to Splines, chapter 11). So limits that hold for v, a and c hold at every instant. In a period the control
/// point is that of the stream where that keeps the limits. Otherwise its acceleration is the one from which
/// a stop, along the limits and seen from the stream, ends at the stream: full jerk towards there or away
/// from it, but for the last periods (stopping_distance.h).
///
/// Set-points are rounded. What that makes of the jerk, `rounding`, is followed: it moves nothing by more
/// than the rounding itself, and to smooth it away would delay what the master asks for.
///
/// Control points are sums of counts x 2^-32, modulo 2^32 counts: nothing is rounded off but what the stream
/// gives, once. Counts and periods throughout. In the main loop; at most 30 ways to rest a period.
class StreamPath {
 public:
  /// All positive.
  struct Limits {
    float velocity = 0.0F;  ///< at most CyclicPosition::kLargestReach
    float speeding = 0.0F;  ///< change of it in a period, while the speed rises
    float slowing = 0.0F;   ///< while it falls
    float jerk = 0.0F;      ///< change of that in a period
    float rounding = 0.0F;  ///< of jerk, that the rounding of set-points makes
    PositionRange range;
  };
  /// A place and how it moves.
  struct State {
    std::int32_t counts = 0;
    float fraction = 0.0F;  ///< of a count; may be more
    float velocity = 0.0F;
    float acceleration = 0.0F;
  };

  void set_limits(const Limits& limits) { limits_ = limits; }
  const Limits& limits() const { return limits_; }

  /// The segment of `newest`, whose set-point comes next, begins in this state.
  void start(std::uint32_t newest, const State& at) {
    const float velocity = approx::clamp(at.velocity, -limits_.velocity, limits_.velocity);
    const float acceleration = at.acceleration;
    velocity_at(newest - 2) = to_fixed(velocity - 0.5F * acceleration);
    velocity_at(newest - 1) = to_fixed(velocity + 0.5F * acceleration);
    asked(newest - 2) = velocity_at(newest - 2);
    asked(newest - 1) = velocity_at(newest - 1);
    control(newest - 2) = (std::uint64_t{static_cast<std::uint32_t>(at.counts)} << 32) +
                          static_cast<std::uint64_t>(to_fixed(at.fraction - acceleration * (1.0F / 6.0F)));
    control(newest - 1) = control(newest - 2) + static_cast<std::uint64_t>(velocity_at(newest - 1));
    follows(newest - 1) = false;
  }

  /// The set-point of a period is a velocity.
  void put_velocity(std::uint32_t period, float wanted) {
    follow_velocity(period, wanted);
    limited_ = !follows(period) || approx::absolute(wanted) > limits_.velocity;
  }
  /// None has come: the velocity goes on changing as it did.
  void extrapolate_velocity(std::uint32_t period) {
    follow_velocity(period, to_float(asked(period - 1)) + own_acceleration(period - 1));
  }

  /// The set-point of a period is a place, and so was that of the one before: counts x 2^-32.
  void put_place(std::uint32_t period, std::uint64_t wanted, std::uint64_t wanted_before) {
    extrapolate_place(period, wanted, wanted_before);
    limited_ = !follows(period) || within_range(wanted) != wanted;
  }
  /// None has come: this is what it would have been.
  void extrapolate_place(std::uint32_t period, std::uint64_t wanted, std::uint64_t wanted_before) {
    const Now now = state_before(period);
    const std::uint64_t place = within_range(wanted);
    asked(period) = static_cast<std::int64_t>(place - within_range(wanted_before));
    const auto way = static_cast<std::int64_t>(place - control(period - 1));
    const float distance = to_float(way);
    const float own = own_acceleration(period);
    const float stream = approx::clamp(to_float(asked(period)), -limits_.velocity, limits_.velocity);
    const float room = limits_.slowing - approx::absolute(own);
    const StoppingDistance rest(room > 0.5F * limits_.slowing ? room : 0.5F * limits_.slowing,
                                kShare * limits_.jerk);
    step(period, now, way, own, [&](float acceleration) {
      const float velocity = now.velocity + acceleration;
      return distance - velocity - rest(velocity - stream, acceleration - own);
    });
  }

  /// The segment that ends a period before the control point of `period`.
  StreamSegment segment(std::uint32_t period) const {
    const std::int64_t v0 = velocity_[(period - 2) % kKept];
    const std::int64_t v1 = velocity_[(period - 1) % kKept];
    const std::int64_t v2 = velocity_[period % kKept];
    const float bend = to_float(v1 - v0);
    StreamSegment made;
    made.counts = counts(period - 2);
    made.b = fraction(period - 2) + bend * (1.0F / 6.0F);
    made.d = 0.5F * to_float(v0 + v1);
    made.s = 0.5F * bend;
    made.k = to_float(v2 - 2 * v1 + v0) * (1.0F / 6.0F);
    return made;
  }

  /// The last set-point was more than the limits allow.
  bool limited() const { return limited_; }

 private:
  static constexpr std::uint32_t kKept = 8;
  static constexpr float kShare =
      0.98F;  ///< of the limits, planned with: the rest makes up for whole periods
  static constexpr int kHalvings = 12;

  // Before the period.
  struct Now {
    float velocity;
    float acceleration;
    float lowest, highest;  // what the acceleration may become, but for the range
    float behind, ahead;    // counts to the ends of the range
  };

  static std::int64_t to_fixed(float counts) { return static_cast<std::int64_t>(counts * 0x1p32F); }
  static float to_float(std::int64_t fixed) { return static_cast<float>(fixed) * 0x1p-32F; }

  std::int64_t& velocity_at(std::uint32_t period) { return velocity_[period % kKept]; }
  std::int64_t& asked(std::uint32_t period) { return asked_[period % kKept]; }
  std::uint64_t& control(std::uint32_t period) { return control_[period % kKept]; }
  bool& follows(std::uint32_t period) { return follows_[period % kKept]; }
  std::int32_t counts(std::uint32_t period) const {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(control_[period % kKept] >> 32));
  }
  float fraction(std::uint32_t period) const {
    return static_cast<float>(static_cast<std::uint32_t>(control_[period % kKept])) * 0x1p-32F;
  }

  void follow_velocity(std::uint32_t period, float wanted) {
    const Now now = state_before(period);
    asked(period) = to_fixed(approx::clamp(wanted, -limits_.velocity, limits_.velocity));
    const float change = to_float(asked(period) - velocity_at(period - 1));
    const float own = own_acceleration(period);
    step(period, now, asked(period), own,
         [&](float acceleration) { return change - acceleration - gained(acceleration - own); });
  }

  Now state_before(std::uint32_t period) {
    const float velocity = to_float(velocity_at(period - 1));
    const float acceleration = to_float(velocity_at(period - 1) - velocity_at(period - 2));
    // What rounding made of it is let go at once.
    const float base = follows(period - 1) ? beyond_rounding(acceleration) : acceleration;
    Now now{velocity, acceleration, base - limits_.jerk, base + limits_.jerk, 0.0F, 0.0F};
    const float most = smaller(largest_gain(velocity), rise_to(limits_.velocity - velocity));
    const float least = -smaller(largest_gain(-velocity), rise_to(limits_.velocity + velocity));
    // Where both cannot be kept, the jerk is.
    if (most < now.highest) now.highest = most > now.lowest ? most : now.lowest;
    if (least > now.lowest) now.lowest = least < now.highest ? least : now.highest;
    const float part = fraction(period - 1);
    const float ahead = limits_.range.room(counts(period - 1), true);
    const float behind = limits_.range.room(counts(period - 1), false);
    // Beyond an end there is no room at all.
    now.ahead = ahead > 0.0F ? ahead - part : 0.0F;
    now.behind = behind > 0.0F ? behind + part : 0.0F;
    return now;
  }

  // `exact` is the step to the stream, `own` the stream's acceleration. `missing(a)` falls with the
  // acceleration a of the period; at zero it is the right one.
  template <class Missing>
  void step(std::uint32_t period, const Now& now, std::int64_t exact, float own, const Missing& missing) {
    const float wanted = to_float(exact - velocity_at(period - 1));
    const float next = to_float(asked(period) - exact) + own;
    follows(period) = may_follow(now, to_float(exact), wanted, next, own);
    std::int64_t given = exact;
    if (!follows(period)) {
      const float towards = root(now.lowest, now.highest, missing);
      given = velocity_at(period - 1) + to_fixed(within_ends(now, towards));
    }
    velocity_at(period) = within_hull(period, given);
    control(period) = control(period - 1) + static_cast<std::uint64_t>(velocity_at(period));
  }

  // To the stream in this period, on it in the `next` one, and from then on with its `own` acceleration.
  bool may_follow(const Now& now, float velocity, float acceleration, float next, float own) const {
    const float jerk = limits_.jerk + limits_.rounding;
    if (approx::absolute(acceleration - now.acceleration) > jerk) return false;
    if (approx::absolute(next - acceleration) > jerk || approx::absolute(own - next) > jerk) return false;
    if (!may_change(now.velocity, acceleration) || !may_change(velocity, next)) return false;
    const float lasting = beyond_rounding(acceleration);
    if (approx::absolute(velocity) > limits_.velocity) return false;
    if (approx::absolute(velocity + gained(lasting)) > limits_.velocity) return false;
    const float end = velocity + stop()(velocity, lasting);
    return end <= now.ahead && end >= -now.behind;
  }

  StoppingDistance stop() const { return {kShare * limits_.slowing, kShare * limits_.jerk}; }

  // A stop from there ends within the range.
  float within_ends(const Now& now, float acceleration) const {
    const StoppingDistance rest = stop();
    const auto end = [&](float a) { return now.velocity + a + rest(now.velocity + a, a); };
    if (end(acceleration) > now.ahead)
      return root(now.lowest, acceleration, [&](float a) { return now.ahead - end(a); });
    if (end(acceleration) < -now.behind)
      return root(acceleration, now.highest, [&](float a) { return -now.behind - end(a); });
    return acceleration;
  }
  // And no control point beyond an end, whatever rounding does.
  std::int64_t within_hull(std::uint32_t period, std::int64_t velocity) {
    const std::uint64_t from = control(period - 1);
    if (within_range(from) != from) return velocity;
    const std::uint64_t to = from + static_cast<std::uint64_t>(velocity);
    return velocity + static_cast<std::int64_t>(within_range(to) - to);
  }
  std::uint64_t within_range(std::uint64_t place) const {
    const auto whole = static_cast<std::int32_t>(static_cast<std::uint32_t>(place >> 32));
    if (limits_.range.room(whole, true) > 0.0F && limits_.range.room(whole, false) > 0.0F) return place;
    const std::int32_t nearest = limits_.range.nearest(whole);
    const bool below = whole == limits_.range.lowest;
    return nearest == whole && below ? place : std::uint64_t{static_cast<std::uint32_t>(nearest)} << 32;
  }

  // The stream's own acceleration; none where it leaps.
  float own_acceleration(std::uint32_t period) {
    const float own = beyond_rounding(to_float(asked(period) - asked(period - 1)));
    const float largest = limits_.speeding > limits_.slowing ? limits_.speeding : limits_.slowing;
    return approx::absolute(own) > largest ? 0.0F : own;
  }

  float beyond_rounding(float acceleration) const {
    return acceleration - approx::clamp(acceleration, -limits_.rounding, limits_.rounding);
  }

  // By what the velocity goes on changing while an acceleration is taken out.
  float gained(float acceleration) const {
    const float size = approx::absolute(acceleration) - 0.5F * limits_.jerk;
    if (size <= 0.5F * limits_.jerk) return 0.0F;
    const float gain = 0.5F * size * size / limits_.jerk;
    return acceleration < 0.0F ? -gain : gain;
  }
  // The largest acceleration with which the velocity rises by no more than that.
  float rise_to(float room) const {
    const float jerk = limits_.jerk;
    if (room <= jerk) return room;
    return approx::fast_square_root(jerk * (2.0F * room)) - 0.5F * jerk;
  }

  // After a velocity `last`: speed may be lost, then won in the other direction.
  float largest_gain(float last) const {
    if (last >= 0.0F) return limits_.speeding;
    return smaller(limits_.slowing, limits_.speeding - last);
  }

  bool may_change(float last, float acceleration) const {
    return acceleration <= largest_gain(last) && -acceleration <= largest_gain(-last);
  }

  static float smaller(float a, float b) { return a < b ? a : b; }

  template <class Function>
  static float root(float low, float high, const Function& falling) {
    if (!(falling(high) < 0.0F)) return high;
    if (!(falling(low) > 0.0F)) return low;
    for (int i = 0; i < kHalvings; ++i) {
      const float middle = 0.5F * (low + high);
      if (falling(middle) > 0.0F) {
        low = middle;
      } else {
        high = middle;
      }
    }
    return low;
  }

  Limits limits_;
  std::array<std::int64_t, kKept> velocity_{};
  std::array<std::int64_t, kKept> asked_{};  // of velocity, by the stream
  std::array<std::uint64_t, kKept> control_{};
  std::array<bool, kKept> follows_{};  // the control point is the stream's
  bool limited_ = false;
};

}  // namespace slipstack
