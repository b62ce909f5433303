// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/friction/displacement.h"
#include "hal/include/encoder.h"

namespace slipstack {

/// Carries the axis over frames that an absolute encoder did not deliver: its counts go on at the velocity of
/// the last tick, for so many ticks, then the loss is a fault. On the way an acceleration a moves the axis by
/// a n^2 T^2 / 2 from there: 0.7 um at 15 m/s^2 and 3 ticks of 0.1 ms. An incremental encoder is never
/// bridged: counts that it did not count are lost.
///
/// A tick that is bridged is earned by kGoodPerBridged good ones, so that a line on which more than one frame
/// in nine is bad becomes a fault as well.
class EncoderBridge {
 public:
  static constexpr std::uint32_t kGoodPerBridged = 8;

  /// In the tick, for a reading that is not valid: makes it valid while it can be bridged by at most `most`
  /// ticks. `tick` counts ticks; `counts` and `step` are those of the tick before.
  void step(EncoderReading& reading, std::uint32_t most, std::uint32_t tick, std::int32_t counts,
            std::int32_t step) {
    const std::uint32_t full = most * kGoodPerBridged;
    const std::uint32_t good = tick - last_bad_ - 1U;
    last_bad_ = tick;
    earned_ = good < full && earned_ + good < full ? earned_ + good : full;
    if (earned_ < kGoodPerBridged) return;
    earned_ -= kGoodPerBridged;
    reading.counts = sum(counts, step);
    reading.valid = true;
  }

 private:
  std::uint32_t last_bad_ = 0;  // the last tick without a position
  std::uint32_t earned_ = 0;    // good ticks that bridging may still use up
};

}  // namespace slipstack
