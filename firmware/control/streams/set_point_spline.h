// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/streams/tracking.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// A cubic over one period: counts + b + d u + s u^2 + k u^3, u from 0 to 1.
struct StreamSegment {
  std::int32_t counts = 0;
  float b = 0.0F, d = 0.0F, s = 0.0F, k = 0.0F;

  /// At the end of a tick that leads to `fraction` x 2^-32 of the period and is `tick` of it long. In the
  /// tick.
  StreamPoint at(std::uint32_t fraction, float tick) const {
    const float u = static_cast<float>(fraction) * 0x1p-32F;
    // The mean velocity of a tick is that of its middle, but for k / 4 of the tick's third power.
    const float middle = u - 0.5F * tick;
    return {counts, b + u * (d + u * (s + u * k)), tick * (d + middle * (2.0F * s + middle * 3.0F * k))};
  }
};

/// Set-points of one period after the other from a master, joined by a uniform cubic B-spline
/// (uniform_spline.h): whatever the set-points are, position, velocity and acceleration are continuous, so
/// that a stream asks no steps of the current.
///
/// It would pass p through the control points c = p - s / 6, s the second difference about p, which needs the
/// set-point after p. That one is not waited for: s is continued from the two before it, 2 s' - s''. Cubics
/// are passed exactly, other motions to within a sixth of their fourth difference, and the spline ends two
/// periods before the newest set-point. Outside the tick.
///
/// Set-points and control points are kept by period, the latter in sixths of a count from an origin that
/// follows: integers, whose differences are exact as long as the set-points of a period lie within
/// CyclicPosition::kLargestReach.
class SetPointSpline {
 public:
  /// Begins with the set-points of four periods, `newest` the last of them, which have been put() in.
  void start(std::uint32_t newest) {
    origin_ = at(newest);
    control(newest - 3) = from_origin(newest - 3) - bend_about(newest - 2);
    control(newest - 2) = from_origin(newest - 2) - bend_about(newest - 2);
    control(newest - 1) = from_origin(newest - 1) - bend_about(newest - 1);
    control(newest) = from_origin(newest) - bend_about(newest - 1);
  }

  void put(std::uint32_t period, std::int32_t counts) { set_point_[period % kKept] = counts; }

  /// Puts in the set-point of a period from the four before it, and returns it: the parabola of least
  /// squares. It takes 2.8 times the rounding of a set-point along, where that through three would take 4.4.
  /// Second differences beyond `largest_bend`, counts per period^2, are not believed.
  std::int32_t extrapolate(std::uint32_t period, std::int32_t largest_bend) {
    const std::int32_t newest = difference(at(period - 1), at(period - 2));
    const std::int32_t older = difference(at(period - 2), at(period - 3));
    const std::int32_t oldest = difference(at(period - 3), at(period - 4));
    // Next less newest: (5, 2, -3) / 4 times the three.
    const std::int32_t bend = (newest + 2 * older - 3 * oldest + 2) >> 2;
    put(period, sum(at(period - 1), newest + limited(bend, largest_bend)));
    return at(period);
  }

  /// Makes the control point of a period, whose set-point is there like those before.
  void lean(std::uint32_t period, std::int32_t largest_bend) {
    follow(at(period));
    const std::int32_t bend = 2 * bend_about(period - 1) - bend_about(period - 2);
    control(period) = from_origin(period) - limited(bend, 2 * largest_bend);
  }

  /// The control point of a period, counts x 2^-32.
  std::uint64_t place(std::uint32_t period) const {
    const auto from_origin = static_cast<std::uint64_t>(std::int64_t{control_[period % kKept]} * kCount / 6);
    return (std::uint64_t{static_cast<std::uint32_t>(origin_)} << 32) + from_origin;
  }

 private:
  static constexpr std::uint32_t kKept = 8;
  static constexpr std::int64_t kCount = std::int64_t{1} << 32;

  std::int32_t at(std::uint32_t period) const { return set_point_[period % kKept]; }
  std::int32_t& control(std::uint32_t period) { return control_[period % kKept]; }
  std::int32_t from_origin(std::uint32_t period) const { return 6 * difference(at(period), origin_); }

  std::int32_t bend_about(std::uint32_t period) const {
    return difference(at(period + 1), at(period)) - difference(at(period), at(period - 1));
  }
  static std::int32_t limited(std::int32_t value, std::int32_t largest) {
    return value > largest ? largest : (value < -largest ? -largest : value);
  }

  void follow(std::int32_t counts) {
    const std::int32_t moved = difference(counts, origin_);
    for (std::int32_t& point : control_) point = difference(point, 6 * moved);
    origin_ = counts;
  }

  std::array<std::int32_t, kKept> set_point_{};
  std::array<std::int32_t, kKept> control_{};
  std::int32_t origin_ = 0;
};

}  // namespace slipstack
