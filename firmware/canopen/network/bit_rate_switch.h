// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/node_parts.h"

namespace slipstack::canopen {

/// The change of bit rate of all nodes (CiA 305, activate bit timing): after the delay every node changes,
/// and after a second one they send again, so that no node receives two rates.
class BitRateSwitch {
 public:
  explicit BitRateSwitch(NodeParts& parts) : parts_(parts) {}

  bool under_way() const { return phase_ != Phase::kNo; }

  /// What waits is sent at the old rate or not at all.
  void begin(std::uint32_t now_us) {
    parts_.outbox.flush(parts_.port);
    parts_.outbox.clear();
    phase_ = Phase::kBefore;
    since_us_ = now_us;
  }

  /// While it is under way; true when the node may send again.
  bool finished(std::uint32_t now_us) {
    const std::uint32_t delay_us = parts_.lss.switch_delay_ms() * 1000U;
    if (now_us - since_us_ < delay_us) return false;
    if (phase_ == Phase::kBefore) {
      static_cast<void>(parts_.port.set_bit_rate(Lss::bits_per_s(parts_.lss.bit_rate())));
      phase_ = Phase::kAfter;
      since_us_ = now_us;
      if (delay_us > 0) return false;
    }
    phase_ = Phase::kNo;
    return true;
  }

 private:
  enum class Phase : std::uint8_t { kNo, kBefore, kAfter };

  NodeParts& parts_;
  Phase phase_ = Phase::kNo;
  std::uint32_t since_us_ = 0;
};

}  // namespace slipstack::canopen
