// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "firmware/canopen/network/outbox.h"
#include "firmware/canopen/network/periodic_timer.h"
#include "firmware/canopen/objects/dictionary.h"

namespace slipstack::canopen {

/// Sends SYNC with its counter where 1005h says so (CiA 301, 7.2.5): period 1006h, counter 1019h.
class SyncProducer {
 public:
  /// The period begins now, or has another length.
  void restart(std::uint32_t now_us) { timer_.restart(now_us); }
  /// The next SYNC counts 1.
  void reset_counter() { counter_ = 0; }

  /// In every poll; true when it has sent a SYNC, whose counter is in `counter` (0: none).
  bool step(const Dictionary& dictionary, std::uint32_t now_us, Outbox& outbox, std::uint8_t& counter) {
    constexpr std::uint32_t kProduces = 1U << 30U;
    const std::uint32_t cob = dictionary.value(kRow<0x1005>);
    if ((cob & kProduces) == 0 || !timer_.due(now_us, dictionary.value(kRow<0x1006>))) return false;
    const auto overflow = static_cast<std::uint8_t>(dictionary.value(kRow<0x1019>));
    const bool counts = overflow > 1;
    if (counts) counter_ = static_cast<std::uint8_t>(counter_ >= overflow ? 1 : counter_ + 1);
    counter = counts ? counter_ : std::uint8_t{0};
    outbox.push(cob & 0x7FF, std::span(&counter, counts ? 1 : 0));
    return true;
  }

 private:
  PeriodicTimer timer_;
  std::uint8_t counter_ = 0;
};

}  // namespace slipstack::canopen
