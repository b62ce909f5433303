// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/supervision/digital_io.h"

namespace slipstack {

/// Keeps the counts at which an input changes, or the index passes: once, after it was armed. An input is
/// seen to the tick, an index to the count.
///
/// Armed outside the tick; costs the tick a comparison while it is not.
class PositionLatch {
 public:
  enum class Event : std::uint8_t {
    kNone,
    kActive,             ///< the inputs are active, or become so
    kInactive,           ///< the inputs are not active, or no longer
    kIndex,              ///< the next index
    kIndexAfterActive,   ///< the first index after the inputs were active
    kIndexAfterInactive  ///< the first index after they were not
  };

  // ---- outside the tick ----

  /// Waits for an event of these inputs, bits of IoMasks.
  void arm(Event event, std::uint32_t inputs = 0) {
    disarm();
    inputs_ = inputs;
    event_.store(event, std::memory_order_release);
  }
  void disarm() {
    event_.store(Event::kNone, std::memory_order_relaxed);
    taken_.store(false, std::memory_order_relaxed);
  }
  bool taken() const { return taken_.load(std::memory_order_acquire); }
  /// Only when taken().
  std::int32_t counts() const { return counts_; }

  // ---- in the tick ----

  bool armed() const { return event_.load(std::memory_order_relaxed) != Event::kNone; }
  void step(const DigitalInputs& inputs, const IoMasks& io, std::int32_t counts) {
    const bool active = (inputs.active(io) & inputs_) != 0;
    switch (event_.load(std::memory_order_acquire)) {
      case Event::kActive:
        if (active) take(counts);
        break;
      case Event::kInactive:
        if (!active) take(counts);
        break;
      case Event::kIndexAfterActive:
        if (active) event_.store(Event::kIndex, std::memory_order_relaxed);
        break;
      case Event::kIndexAfterInactive:
        if (!active) event_.store(Event::kIndex, std::memory_order_relaxed);
        break;
      default:
        break;
    }
  }
  void index_passed(std::int32_t counts) {
    if (event_.load(std::memory_order_acquire) == Event::kIndex) take(counts);
  }

 private:
  void take(std::int32_t counts) {
    counts_ = counts;
    event_.store(Event::kNone, std::memory_order_relaxed);
    taken_.store(true, std::memory_order_release);
  }

  std::atomic<Event> event_{Event::kNone};
  std::atomic<bool> taken_{false};
  std::uint32_t inputs_ = 0;
  std::int32_t counts_ = 0;
};

}  // namespace slipstack
