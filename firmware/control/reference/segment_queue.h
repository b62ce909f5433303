// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/control/reference/fixed_motion.h"

namespace slipstack {

/// Segments on their way from the main loop to the tick, in order.
class SegmentQueue {
 public:
  static constexpr std::uint32_t kCapacity = 16;

  // ---- outside the tick ----

  /// Free places.
  std::uint32_t free() const {
    return kCapacity - (pushed_.load(std::memory_order_relaxed) - taken_.load(std::memory_order_acquire));
  }
  /// False when the queue is full, or the segment has no tick.
  bool push(const MotionSegment& segment) {
    if (free() == 0 || segment.ticks <= 0) return false;
    const std::uint32_t at = pushed_.load(std::memory_order_relaxed);
    queue_[at % kCapacity] = segment;
    pushed_.store(at + 1, std::memory_order_release);
    return true;
  }

  // ---- in the tick ----

  std::uint32_t pushed() const { return pushed_.load(std::memory_order_relaxed); }
  /// The segment after the first `taken`; nullptr where there is none.
  const MotionSegment* after(std::uint32_t taken) const {
    const std::uint32_t pushed = pushed_.load(std::memory_order_relaxed);
    std::atomic_signal_fence(std::memory_order_acquire);
    return taken != pushed ? &queue_[taken % kCapacity] : nullptr;
  }
  /// Their places are free again.
  void free_up_to(std::uint32_t taken) { taken_.store(taken, std::memory_order_relaxed); }
  /// Forgets what is queued; returns how many segments that is since the start. The main loop may call this
  /// as well.
  std::uint32_t forget() {
    const std::uint32_t pushed = pushed_.load(std::memory_order_relaxed);
    std::atomic_signal_fence(std::memory_order_acq_rel);
    taken_.store(pushed, std::memory_order_relaxed);
    return pushed;
  }

 private:
  std::atomic<std::uint32_t> pushed_{0};
  std::atomic<std::uint32_t> taken_{0};
  std::array<MotionSegment, kCapacity> queue_{};
};

}  // namespace slipstack
