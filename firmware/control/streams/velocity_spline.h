// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/bounds/position_range.h"
#include "firmware/control/bounds/set_point_range.h"
#include "firmware/control/streams/set_point_spline.h"

namespace slipstack {

/// Set-points of velocity from a master, one a period, summed up to a path: a uniform cubic B-spline whose
/// control points c lie the set-points v apart, c[n] = c[n - 1] + v[n]. Its velocity is the quadratic
/// B-spline of the set-points: it never overshoots them, its acceleration runs in straight lines through
/// v[n] - v[n - 1], and it is there a period and a half after them. (Splines through given places,
/// set_point_spline.h, have to lean out to pass them.)
///
/// The control points are sums of counts x 2^-32, modulo 2^32 counts: nothing is rounded off but the
/// set-points themselves, once. Counts and periods throughout. Outside the tick.
class VelocitySpline {
 public:
  /// Bounds of the set-points; all positive.
  struct Limits {
    float velocity = 0.0F;  ///< at most CyclicPosition::kLargestReach
    float speeding = 0.0F;  ///< change in a period, while the speed rises
    float slowing = 0.0F;   ///< while it falls
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

  /// The segment of `newest`, whose set-point is put() next, begins in this state.
  void start(std::uint32_t newest, const State& at) {
    const float acceleration = approx::clamp(at.acceleration, -limits_.slowing, limits_.slowing);
    const float velocity = approx::clamp(at.velocity, -limits_.velocity, limits_.velocity);
    velocity_at(newest - 2) = to_fixed(velocity - 0.5F * acceleration);
    velocity_at(newest - 1) = to_fixed(velocity + 0.5F * acceleration);
    control(newest - 2) = (std::uint64_t{static_cast<std::uint32_t>(at.counts)} << 32) +
                          static_cast<std::uint64_t>(to_fixed(at.fraction - acceleration * (1.0F / 6.0F)));
    control(newest - 1) = control(newest - 2) + static_cast<std::uint64_t>(velocity_at(newest - 1));
  }

  /// The set-point of a period, or as much of it as the limits allow after the one before.
  void put(std::uint32_t period, float wanted) {
    const float given = within(period, wanted);
    limited_ = given != wanted;
    keep(period, given);
  }
  /// The set-point of a period for which none has come: the velocity goes on changing as it did. Here and
  /// below, no bend of the path is larger than its own limits.
  void extrapolate(std::uint32_t period, std::int32_t) {
    const float last = velocity(period - 1);
    keep(period, within(period, last + (last - velocity(period - 2))));
  }

  /// The segment that ends a period before the sum up to the set-point of `period`.
  StreamSegment segment(std::uint32_t period, std::int32_t) {
    const std::int64_t v0 = velocity_at(period - 2);
    const std::int64_t v1 = velocity_at(period - 1);
    const std::int64_t v2 = velocity_at(period);
    const float bend = to_float(v1 - v0);
    StreamSegment made;
    made.counts = counts(period - 2);
    made.b = fraction(period - 2) + bend * (1.0F / 6.0F);
    made.d = 0.5F * to_float(v0 + v1);
    made.s = 0.5F * bend;
    made.k = to_float(v2 - 2 * v1 + v0) * (1.0F / 6.0F);
    return made;
  }

  /// The control point of a period.
  std::int32_t counts(std::uint32_t period) const {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(control_[period % kKept] >> 32));
  }
  float fraction(std::uint32_t period) const {
    return static_cast<float>(static_cast<std::uint32_t>(control_[period % kKept])) * 0x1p-32F;
  }

  /// The last set-point was more than the limits allow.
  bool limited() const { return limited_; }

 private:
  static constexpr std::uint32_t kKept = 8;

  static std::int64_t to_fixed(float counts) { return static_cast<std::int64_t>(counts * 0x1p32F); }
  static float to_float(std::int64_t fixed) { return static_cast<float>(fixed) * 0x1p-32F; }

  std::int64_t& velocity_at(std::uint32_t period) { return velocity_[period % kKept]; }
  std::uint64_t& control(std::uint32_t period) { return control_[period % kKept]; }
  float velocity(std::uint32_t period) const { return to_float(velocity_[period % kKept]); }

  void keep(std::uint32_t period, float counts) {
    velocity_at(period) = to_fixed(counts);
    control(period) = control(period - 1) + static_cast<std::uint64_t>(velocity_at(period));
  }

  float within(std::uint32_t period, float wanted) {
    const float last = velocity(period - 1);
    const float limited = approx::clamp(wanted, -limits_.velocity, limits_.velocity);
    const float changed = approx::clamp(limited, -highest(-last), highest(last));
    const float room = limits_.range.room(counts(period - 1), changed > 0.0F);
    // Half of the deceleration, as for every stream: the last periods to the end are whole ones.
    const float most = SetPointRange::farthest(room, 0.5F * limits_.slowing);
    return approx::clamp(changed, -most, most);
  }

  // After a set-point `last`: speed may be lost, then won in the other direction.
  float highest(float last) const {
    if (last >= 0.0F) return last + limits_.speeding;
    const float slower = last + limits_.slowing;
    return slower < limits_.speeding ? slower : limits_.speeding;
  }

  Limits limits_;
  std::array<std::int64_t, kKept> velocity_{};
  std::array<std::uint64_t, kKept> control_{};
  bool limited_ = false;
};

}  // namespace slipstack
