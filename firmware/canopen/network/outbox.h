// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/canopen/network/counter.h"
#include "hal/include/can_port.h"

namespace slipstack::canopen {

/// Frames on their way to the port, oldest first. A frame that finds no room is counted and gone.
class Outbox {
 public:
  static constexpr std::size_t kCapacity = 32;

  bool push(const CanFrame& frame) {
    if (count_ == kCapacity) {
      count(lost_);
      return false;
    }
    frames_[(first_ + count_) % kCapacity] = frame;
    ++count_;
    return true;
  }
  bool push(std::uint32_t id, std::span<const std::uint8_t> data) {
    CanFrame frame;
    frame.id = id;
    frame.length = static_cast<std::uint8_t>(data.size());
    for (std::size_t i = 0; i < data.size(); ++i) frame.data[i] = data[i];
    return push(frame);
  }
  /// Gives the port what it takes.
  void flush(CanPort& port) {
    while (count_ > 0 && port.send(frames_[first_])) {
      first_ = (first_ + 1) % kCapacity;
      --count_;
    }
  }
  void clear() { count_ = 0; }
  std::size_t room() const { return kCapacity - count_; }
  std::uint32_t lost() const { return lost_; }

 private:
  std::array<CanFrame, kCapacity> frames_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::uint32_t lost_ = 0;
};

}  // namespace slipstack::canopen
