// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack {

/// Positions are whole encoder counts and a fraction, their changes per tick are in counts x 2^-44: sums of
/// such numbers are exact, so that a motion of any length ends where it was planned to end. 2 m/s at counts
/// of 1 nm and 10 kHz are 2 10^5 counts per tick, for which 18 bits remain before the point.
inline constexpr int kFractionBits = 44;

/// Velocity, acceleration and jerk stay below this many counts per tick, tick^2 and tick^3; checked with the
/// parameters. Twice as much is representable.
inline constexpr float kLargestRate = 0x1p18F;

/// value x 2^-44 as a float, without a 64-bit conversion (a library call on the target).
inline float from_fixed(std::int64_t value) {
  const auto high = static_cast<std::int32_t>(value >> 32);
  const auto low = static_cast<std::uint32_t>(value & 0xFFFFFFFF);
  return static_cast<float>(high) * 0x1p-12F + static_cast<float>(low) * 0x1p-44F;
}

/// counts x 2^44, rounded towards zero, for |counts| < 2^19; outside the tick.
inline std::int64_t to_fixed(float counts) {
  const auto whole = static_cast<std::int32_t>(counts);
  const float below = counts - static_cast<float>(whole);
  const auto upper = static_cast<std::int32_t>(below * 0x1p24F);
  const float lower = below * 0x1p24F - static_cast<float>(upper);
  return static_cast<std::int64_t>(whole) * (std::int64_t{1} << kFractionBits) +
         static_cast<std::int64_t>(upper) * (std::int64_t{1} << (kFractionBits - 24)) +
         static_cast<std::int64_t>(static_cast<std::int32_t>(lower * 0x1p20F));
}

/// A segment of motion with constant jerk. Each tick: a += jerk, v += a, x += v. Acceleration and jerk have
/// `shift` more binary places, so that slow ramps of many ticks keep their form.
struct MotionSegment {
  std::int64_t ticks = 0;
  std::int32_t start_counts = 0;    ///< where it begins, if `sets_position`
  std::int64_t start_fraction = 0;  ///< of a count x 2^-44
  std::int64_t velocity = 0;        ///< at its begin, counts per tick x 2^-44
  std::int64_t acceleration = 0;    ///< counts per tick^2 x 2^-(44 + shift)
  std::int64_t jerk = 0;            ///< counts per tick^3 x 2^-(44 + shift)
  std::int32_t shift = 0;           ///< 0 to kLargestShift
  bool sets_position = false;
};
inline constexpr std::int32_t kLargestShift = 31;

/// value / 2^shift, rounded down, for 0 <= shift <= kLargestShift: half the instructions of a shift by any
/// number.
inline std::int64_t shifted_down(std::int64_t value, std::int32_t shift) {
  const auto high = static_cast<std::int32_t>(value >> 32);
  const auto low = static_cast<std::uint32_t>(value & 0xFFFFFFFF);
  const std::uint32_t carried = (static_cast<std::uint32_t>(high) << 1) << (31 - shift);
  return static_cast<std::int64_t>(high >> shift) * (std::int64_t{1} << 32) +
         static_cast<std::int64_t>((low >> shift) | carried);
}

}  // namespace slipstack
