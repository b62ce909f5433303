// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/friction/displacement.h"

namespace slipstack {

/// Set-points of one period after the other, joined by a uniform cubic B-spline (de Boor, A Practical Guide to
/// Splines, chapter 9): whatever the set-points are, position, velocity and acceleration are continuous, so
/// that a stream asks no steps of the current.
///
/// It would pass p through the control points c = p - s / 6, s the second difference about p, which needs the
/// set-point after p. That one is not waited for: s is continued from the two before it, 2 s' - s''. Cubics are
/// passed exactly, other motions to within a sixth of their fourth difference, and the spline ends two periods
/// before the newest set-point. In the tick.
///
/// Control points are kept in sixths of a count, from an origin that follows: integers, whose differences are
/// exact as long as the set-points of a period lie within CyclicPosition::kLargestReach.
class SetPointSpline {
 public:
  struct Place {
    std::int32_t counts = 0;
    std::uint32_t fraction = 0;  ///< of a count x 2^-32
  };

  /// Begins with the last four set-points, newest first.
  void start(const std::array<std::int32_t, 4>& last) {
    last_ = {last[0], last[1], last[2]};
    origin_ = last[0];
    const auto from_origin = [&](std::size_t i) { return 6 * difference(last[i], origin_); };
    const std::int32_t newer = bend_about(last[0], last[1], last[2]);
    const std::int32_t older = bend_about(last[1], last[2], last[3]);
    control_ = {from_origin(3) - older, from_origin(2) - older, from_origin(1) - newer, -newer};
  }

  /// The set-point `ago` before the newest one, to be corrected by one that came late.
  std::int32_t& set_point(std::size_t ago) { return last_[ago]; }

  /// The set-point after the newest one, by constant acceleration: by one that `largest_bend`, counts per
  /// period^2, allows.
  std::int32_t extrapolated(std::int32_t largest_bend) const {
    const std::int32_t bend = limited(bend_about(last_[0], last_[1], last_[2]), largest_bend);
    return sum(last_[0], difference(last_[0], last_[1]) + bend);
  }

  /// One period on.
  void append(std::int32_t set_point, std::int32_t largest_bend) {
    const std::int32_t before = bend_about(last_[0], last_[1], last_[2]);
    const std::int32_t bend = bend_about(set_point, last_[0], last_[1]);
    const std::int32_t ahead = limited(2 * bend - before, 2 * largest_bend);
    const std::int32_t moved = difference(set_point, origin_);
    control_ = {control_[1] - 6 * moved, control_[2] - 6 * moved, control_[3] - 6 * moved, -ahead};
    origin_ = set_point;
    last_ = {set_point, last_[0], last_[1]};
  }

  /// `fraction`: of the period, 2^-32.
  Place at(std::uint32_t fraction) const {
    // With differences d, second ones s and the third t of the control points c0 to c3, in 1/36 count:
    // 6 c1 + s0 + 3 (d0 + d1) u + 3 s0 u^2 + t u^3. The coefficients are exact, u has 31 places.
    const std::int32_t d0 = control_[1] - control_[0];
    const std::int32_t d1 = control_[2] - control_[1];
    const std::int32_t s0 = d1 - d0;
    const std::int32_t t = control_[3] - control_[2] - d1 - s0;
    const auto u = static_cast<std::int32_t>(fraction >> 1);
    std::int64_t sum36 = static_cast<std::int64_t>(t) * u;
    sum36 = times(sum36 + shifted(3 * static_cast<std::int64_t>(s0)), u);
    sum36 = times(sum36 + shifted(3 * (static_cast<std::int64_t>(d0) + d1)), u);
    sum36 += shifted(6 * static_cast<std::int64_t>(control_[1]) + s0);
    const std::int64_t counts = thirty_sixth(sum36);
    return {sum(origin_, static_cast<std::int32_t>(counts >> 31)), static_cast<std::uint32_t>(counts) << 1};
  }

 private:
  static std::int32_t bend_about(std::int32_t next, std::int32_t here, std::int32_t before) {
    return difference(next, here) - difference(here, before);
  }
  static std::int32_t limited(std::int32_t value, std::int32_t largest) {
    return value > largest ? largest : (value < -largest ? -largest : value);
  }
  static std::int64_t shifted(std::int64_t value) { return value * (std::int64_t{1} << 31); }

  // a u, u with 31 places: two multiplications of 32 bits.
  static std::int64_t times(std::int64_t a, std::int32_t u) {
    const auto high = static_cast<std::int32_t>(a >> 32);
    const auto low = static_cast<std::uint32_t>(a);
    return static_cast<std::int64_t>(high) * u * 2 +
           static_cast<std::int64_t>((static_cast<std::uint64_t>(low) * static_cast<std::uint32_t>(u)) >> 31);
  }

  // a / 36 by the reciprocal x 2^36: to 2 10^-10 of it.
  static std::int64_t thirty_sixth(std::int64_t a) {
    constexpr std::uint32_t kReciprocal = 1908874354;  // 2^36 / 36, rounded
    const auto high = static_cast<std::int32_t>(a >> 32);
    const auto low = static_cast<std::uint32_t>(a);
    const std::int64_t product =
        static_cast<std::int64_t>(high) * static_cast<std::int32_t>(kReciprocal) +
        static_cast<std::int64_t>((static_cast<std::uint64_t>(low) * kReciprocal) >> 32);
    return product >> 4;
  }

  std::array<std::int32_t, 3> last_{};     // set-points, newest first
  std::array<std::int32_t, 4> control_{};  // oldest first, sixths of a count from the origin
  std::int32_t origin_ = 0;
};

}  // namespace slipstack
