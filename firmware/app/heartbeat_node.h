// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/app/application.h"

namespace slipstack {

/// The smallest node: announces itself on the bus and accepts no commands. Boot-up message and heartbeat of
/// CiA 301 (7.2.8.3: identifier 700h + node), the state always pre-operational; frames that come in are
/// counted and dropped, bus-off is left after a second.
class HeartbeatNode {
 public:
  explicit HeartbeatNode(std::uint8_t node_id) : node_id_(node_id) {}

  void start(NodeContext& context) { send(context, kBootUp); }

  void serve(NodeContext& context, std::uint32_t now_us) {
    CanFrame frame;
    for (int i = 0; i < kMostFrames && context.can.receive(frame); ++i) ++received_;
    if (now_us - last_us_ < kPeriod_us) return;
    last_us_ = now_us;
    if (context.can.status().state == CanBusState::kOff) context.can.recover();
    send(context, kPreOperational);
  }

  std::uint32_t received() const { return received_; }

 private:
  static constexpr std::uint32_t kPeriod_us = 1'000'000;
  static constexpr int kMostFrames = 8;  // in one pass
  static constexpr std::uint8_t kBootUp = 0x00;
  static constexpr std::uint8_t kPreOperational = 0x7F;

  void send(NodeContext& context, std::uint8_t state) {
    CanFrame frame;
    frame.id = 0x700U + node_id_;
    frame.length = 1;
    frame.data[0] = state;
    static_cast<void>(context.can.send(frame));
  }

  std::uint8_t node_id_;
  std::uint32_t last_us_ = 0;
  std::uint32_t received_ = 0;
};

}  // namespace slipstack
