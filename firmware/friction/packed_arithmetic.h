// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#if defined(__ARM_FEATURE_SAT)
#include <arm_acle.h>
#endif

// Two signed 16-bit lanes in one word, as the DSP instructions of Armv7E-M treat them. On the target each
// function is one instruction; elsewhere the portable form gives the same bits. The portable forms are
// visible on every platform, so that a test on the target can hold the instructions against them.
namespace slipstack {

namespace portable {

constexpr std::int32_t low_lane(std::uint32_t word) {
  return static_cast<std::int16_t>(word & 0xFFFFU);
}
constexpr std::int32_t high_lane(std::uint32_t word) {
  return static_cast<std::int16_t>(word >> 16);
}

constexpr std::int32_t saturate16(std::int32_t value) {
  return value > 32767 ? 32767 : (value < -32768 ? -32768 : value);
}

constexpr std::uint32_t pack(std::int32_t low, std::int32_t high) {
  return (static_cast<std::uint32_t>(high) << 16) | (static_cast<std::uint32_t>(low) & 0xFFFFU);
}

constexpr std::uint32_t add_saturating(std::uint32_t a, std::uint32_t b) {
  return pack(saturate16(low_lane(a) + low_lane(b)), saturate16(high_lane(a) + high_lane(b)));
}

constexpr std::uint32_t add_saturating_unsigned(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t low = (a & 0xFFFFU) + (b & 0xFFFFU);
  const std::uint32_t high = (a >> 16) + (b >> 16);
  return (low > 0xFFFFU ? 0xFFFFU : low) | ((high > 0xFFFFU ? 0xFFFFU : high) << 16);
}
constexpr std::uint32_t subtract_saturating_unsigned(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t low = (a & 0xFFFFU) > (b & 0xFFFFU) ? (a & 0xFFFFU) - (b & 0xFFFFU) : 0U;
  const std::uint32_t high = (a >> 16) > (b >> 16) ? (a >> 16) - (b >> 16) : 0U;
  return low | (high << 16);
}

constexpr std::uint32_t multiply_add(std::uint32_t a, std::uint32_t b, std::uint32_t accumulator) {
  return accumulator + static_cast<std::uint32_t>(low_lane(a) * low_lane(b)) +
         static_cast<std::uint32_t>(high_lane(a) * high_lane(b));
}

}  // namespace portable

// Value limited to [-32768, 32767] (SSAT).
inline std::int32_t saturate16(std::int32_t value) {
#if defined(__ARM_FEATURE_SAT)
  return __ssat(value, 16);
#else
  return portable::saturate16(value);
#endif
}

// The same value, within [-32768, 32767], in both lanes (PKHBT; the compiler does not find it by itself).
inline std::uint32_t both_lanes(std::int32_t value) {
#if defined(__ARM_FEATURE_SIMD32)
  std::uint32_t word = 0;
  asm("pkhbt %0, %1, %1, lsl #16" : "=r"(word) : "r"(value));
  return word;
#else
  return portable::pack(value, value);
#endif
}

// Both lanes a + b, each limited to [-32768, 32767] (QADD16).
inline std::uint32_t add_saturating(std::uint32_t a, std::uint32_t b) {
#if defined(__ARM_FEATURE_SIMD32)
  return static_cast<std::uint32_t>(__qadd16(static_cast<int16x2_t>(a), static_cast<int16x2_t>(b)));
#else
  return portable::add_saturating(a, b);
#endif
}

// Both lanes, unsigned, a + b limited to 65535 (UQADD16), and a - b limited to 0 (UQSUB16).
inline std::uint32_t add_saturating_unsigned(std::uint32_t a, std::uint32_t b) {
#if defined(__ARM_FEATURE_SIMD32)
  return static_cast<std::uint32_t>(__uqadd16(static_cast<uint16x2_t>(a), static_cast<uint16x2_t>(b)));
#else
  return portable::add_saturating_unsigned(a, b);
#endif
}
inline std::uint32_t subtract_saturating_unsigned(std::uint32_t a, std::uint32_t b) {
#if defined(__ARM_FEATURE_SIMD32)
  return static_cast<std::uint32_t>(__uqsub16(static_cast<uint16x2_t>(a), static_cast<uint16x2_t>(b)));
#else
  return portable::subtract_saturating_unsigned(a, b);
#endif
}

// accumulator + a.low b.low + a.high b.high, modulo 2^32 (SMLAD).
inline std::uint32_t multiply_add(std::uint32_t a, std::uint32_t b, std::uint32_t accumulator) {
#if defined(__ARM_FEATURE_SIMD32)
  return static_cast<std::uint32_t>(
      __smlad(static_cast<int16x2_t>(a), static_cast<int16x2_t>(b), static_cast<std::int32_t>(accumulator)));
#else
  return portable::multiply_add(a, b, accumulator);
#endif
}

}  // namespace slipstack
