// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "hal/include/can_port.h"

namespace slipstack::stm32g474 {

// Frames on their way from one interrupt to the main loop: one writer, one reader, no lock. Holds `kCapacity`
// frames.
template <std::uint32_t kCapacity>
class CanRing {
  static_assert((kCapacity & (kCapacity - 1)) == 0, "indices wrap at a power of two");

 public:
  // For the writer. False when full: the frame is dropped.
  bool push(const CanFrame& frame) {
    const std::uint32_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) >= kCapacity) return false;
    frames_[written % kCapacity] = frame;
    written_.store(written + 1, std::memory_order_release);
    return true;
  }

  // For the reader. False when empty.
  bool pop(CanFrame& frame) {
    const std::uint32_t read = read_.load(std::memory_order_relaxed);
    if (read == written_.load(std::memory_order_acquire)) return false;
    frame = frames_[read % kCapacity];
    read_.store(read + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<CanFrame, kCapacity> frames_{};
  std::atomic<std::uint32_t> written_{0};
  std::atomic<std::uint32_t> read_{0};
};

}  // namespace slipstack::stm32g474
