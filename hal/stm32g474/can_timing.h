// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// Bit timing of classic CAN on the FDCAN. RM0440, FD controller area network (FDCAN), bit timing, FDCAN_NBTP.
namespace slipstack::stm32g474 {

// Counts of time quanta, not yet less one as the register wants them.
struct CanBitTiming {
  std::uint32_t prescaler = 0;  // 1 ... 512; 0: there is no timing
  std::uint32_t segment_1 =
      0;  // 2 ... 256, propagation and phase 1, after the one quantum of synchronisation
  std::uint32_t segment_2 = 0;  // 2 ... 128
  std::uint32_t jump_width = 0;

  constexpr bool valid() const { return prescaler > 0; }
  constexpr std::uint32_t quanta() const { return 1 + segment_1 + segment_2; }
  constexpr std::uint32_t bit_rate(std::uint32_t clock_Hz) const { return clock_Hz / (prescaler * quanta()); }
  // Where the bit is sampled, in 1/10000 of it.
  constexpr std::uint32_t sample_point_e4() const { return 10'000 * (1 + segment_1) / quanta(); }
  // How far the clocks of two nodes may be from the nominal frequency, each, in millionths: the lesser of the
  // two conditions of ISO 11898-1 (ten bits between resynchronisations; 13 bits from an error to the sixth
  // bit of its flag).
  constexpr std::uint32_t clock_tolerance_ppm() const {
    const std::uint32_t phase = segment_1 < segment_2 ? segment_1 : segment_2;
    const std::uint32_t by_jump = 1'000'000 * jump_width / (20 * quanta());
    const std::uint32_t by_phase = 1'000'000 * phase / (2 * (13 * quanta() - segment_2));
    return by_jump < by_phase ? by_jump : by_phase;
  }
};

// CiA 301, table 1: the sample point is as near to 87.5 % of the bit as possible; we never go beyond.
inline constexpr std::uint32_t kLatestSamplePoint_e4 = 8750;
inline constexpr std::uint32_t kEarliestSamplePoint_e4 = 7500;

// The timing whose bit rate is exact, whose sample point is the nearest to 87.5 % from below, and among those
// the one with the most quanta. Not valid when no timing samples within [75 %, 87.5 %] at exactly this rate.
// Tries every prescaler: meant for constants, so that a clock that does not suit CAN does not compile.
constexpr CanBitTiming plan_can_timing(std::uint32_t clock_Hz, std::uint32_t bit_rate) {
  CanBitTiming best;
  for (std::uint32_t prescaler = 1; prescaler <= 512; ++prescaler) {
    const std::uint64_t divisor = std::uint64_t{prescaler} * bit_rate;
    if (divisor == 0 || clock_Hz % divisor != 0) continue;
    const auto quanta = static_cast<std::uint32_t>(clock_Hz / divisor);
    if (quanta < 8 || quanta > 385) continue;
    // Quanta after the sample point: 12.5 % of the bit, rounded up, and at least the two that the FDCAN
    // needs.
    const std::uint32_t after = quanta - quanta * kLatestSamplePoint_e4 / 10'000;
    const std::uint32_t segment_2 = after < 2 ? 2 : after;
    const CanBitTiming timing{prescaler, quanta - segment_2 - 1, segment_2, segment_2};
    if (timing.segment_1 < 2 || timing.segment_1 > 256 || timing.segment_2 < 2 || timing.segment_2 > 128)
      continue;
    if (timing.sample_point_e4() < kEarliestSamplePoint_e4) continue;
    if (!best.valid() || timing.sample_point_e4() > best.sample_point_e4()) best = timing;
  }
  return best;
}

}  // namespace slipstack::stm32g474
