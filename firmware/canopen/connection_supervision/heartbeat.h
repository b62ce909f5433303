// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/canopen/objects/dictionary.h"

namespace slipstack::canopen {

enum class NmtState : std::uint8_t {
  kInitialising = 0,
  kStopped = 4,
  kOperational = 5,
  kPreOperational = 127
};

/// Heartbeat consumer 1016h: watches a node from its first heartbeat on (CiA 301, 7.2.8.2.2.2).
class HeartbeatConsumer {
 public:
  explicit HeartbeatConsumer(Dictionary& dictionary) : dictionary_(dictionary) {}

  void reset() { watched_ = {}; }
  void restart(std::size_t row) { watched_[row - kRow<0x1016, 1>] = {}; }

  void receive(std::uint8_t node, std::uint32_t now_us) {
    for (std::size_t i = 0; i < kHeartbeatSources; ++i) {
      if (node_of(i) == node && time_us(i) != 0) watched_[i] = {true, false, now_us};
    }
  }

  /// The node whose heartbeat just failed to come, 0 if none did.
  std::uint8_t step(std::uint32_t now_us) {
    for (std::size_t i = 0; i < kHeartbeatSources; ++i) {
      Watched& own = watched_[i];
      if (!own.seen || own.lost || now_us - own.last_us <= time_us(i)) continue;
      own.lost = true;
      return node_of(i);
    }
    return 0;
  }
  bool any_lost() const {
    for (const Watched& own : watched_) {
      if (own.lost) return true;
    }
    return false;
  }

  /// 1016h: one entry a node; the reserved bits zero.
  Abort check(std::size_t row, std::uint32_t value) const {
    if ((value >> 24) != 0) return Abort::kBadValue;
    const std::uint32_t node = (value >> 16) & 0xFF;
    if ((value & 0xFFFF) == 0 || node == 0) return Abort::kNone;
    if (node > 127) return Abort::kBadValue;
    for (std::size_t i = 0; i < kHeartbeatSources; ++i) {
      if (kRow<0x1016, 1> + i != row && node_of(i) == node && time_us(i) != 0) return Abort::kIncompatible;
    }
    return Abort::kNone;
  }

 private:
  struct Watched {
    bool seen = false;
    bool lost = false;
    std::uint32_t last_us = 0;
  };
  std::uint8_t node_of(std::size_t i) const {
    return static_cast<std::uint8_t>(dictionary_.value(kRow<0x1016, 1> + i) >> 16);
  }
  std::uint32_t time_us(std::size_t i) const {
    return (dictionary_.value(kRow<0x1016, 1> + i) & 0xFFFF) * 1000U;
  }

  Dictionary& dictionary_;
  std::array<Watched, kHeartbeatSources> watched_{};
};

}  // namespace slipstack::canopen
