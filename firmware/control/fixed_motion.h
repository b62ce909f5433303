// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack {

/// Positions are whole encoder counts and a fraction, their changes per tick are in counts x 2^-48: sums of
/// such numbers are exact, so that a motion of any length ends where it was planned to end.
inline constexpr int kFractionBits = 48;

/// value x 2^-48 as a float, without a 64-bit conversion (a library call on the target).
inline float from_fixed(std::int64_t value) {
  const auto high = static_cast<std::int32_t>(value >> 32);
  const auto low = static_cast<std::uint32_t>(value & 0xFFFFFFFF);
  return static_cast<float>(high) * 0x1p-16F + static_cast<float>(low) * 0x1p-48F;
}

/// counts x 2^48, rounded, for |counts| < 2^15; outside the tick.
inline std::int64_t to_fixed(float counts) {
  const auto whole = static_cast<std::int32_t>(counts);
  const float below = counts - static_cast<float>(whole);
  const auto upper = static_cast<std::int32_t>(below * 0x1p24F);
  const float lower = below * 0x1p24F - static_cast<float>(upper);
  return static_cast<std::int64_t>(whole) * (std::int64_t{1} << kFractionBits) +
         static_cast<std::int64_t>(upper) * (std::int64_t{1} << 24) +
         static_cast<std::int64_t>(static_cast<std::int32_t>(lower * 0x1p24F));
}

/// A segment of motion with constant jerk. Each tick: a += jerk, v += a, x += v.
struct MotionSegment {
  std::int32_t ticks = 0;
  std::int32_t start_counts = 0;    ///< where it begins, if `sets_position`
  std::int64_t start_fraction = 0;  ///< of a count x 2^-48
  std::int64_t velocity = 0;        ///< at its begin, counts per tick x 2^-48
  std::int64_t acceleration = 0;    ///< counts per tick^2 x 2^-48
  std::int64_t jerk = 0;            ///< counts per tick^3 x 2^-48
  bool sets_position = false;
};

/// The state after n ticks of a segment, but for the position.
constexpr MotionSegment after(const MotionSegment& segment) {
  const std::int64_t n = segment.ticks;
  MotionSegment next;
  next.velocity = segment.velocity + n * segment.acceleration + segment.jerk * (n * (n + 1) / 2);
  next.acceleration = segment.acceleration + n * segment.jerk;
  return next;
}

}  // namespace slipstack
