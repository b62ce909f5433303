// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/connection_supervision/bus_watch.h"
#include "firmware/canopen/connection_supervision/lost_connection.h"
#include "firmware/canopen/network/bit_rate_switch.h"
#include "firmware/canopen/node_parts.h"
#include "firmware/canopen/objects/node_objects.h"

namespace slipstack::canopen {

/// A CANopen device (CiA 301): NMT, heartbeat, SDO, PDO, SYNC, EMCY, LSS, stored parameters, access lock.
///
/// poll() from the main loop, never from the tick: at most kFramesPerPoll frames are taken from the port and
/// kBlockFramesPerPoll segments of a block upload sent; time is passed in, in us modulo 2^32.
class Node {
 public:
  static constexpr int kFramesPerPoll = 16;
  static constexpr int kBlockFramesPerPoll = 8;
  static constexpr std::uint32_t kBusOffWait_us = BusWatch::kBusOffWait_us;
  static constexpr std::uint32_t kEventHeld_us = BusWatch::kEventHeld_us;

  Node(CanPort& port, RecordSlots& storage, Application& application);

  /// At the start: reads what is stored. `node`: the id if none is stored, FFh to wait for LSS.
  void start(std::uint8_t node, std::uint32_t now_us);
  void poll(std::uint32_t now_us);

  NmtState state() const { return state_; }
  std::uint8_t id() const { return parts_.node; }
  /// Has an id, and what it sends is acknowledged: a node alone on its bus becomes error passive with its
  /// boot-up message.
  bool takes_part() const {
    const CanBusState bus = parts_.port.status().state;
    const bool on_bus = bus == CanBusState::kActive || bus == CanBusState::kWarning;
    return parts_.node != Lss::kUnconfigured && on_bus;
  }
  Dictionary& dictionary() { return parts_.dictionary; }
  const AccessLock& lock() const { return parts_.lock; }

 private:
  // ---- frames in ----

  void take(const CanFrame& frame, std::uint32_t now_us);
  // Identifiers that only this node may send: another node has its node id, or that of one of its PDOs.
  bool is_own(std::uint32_t id) const;
  void take_nmt(const CanFrame& frame, std::uint32_t now_us);
  void take_sdo(const CanFrame& frame, std::uint32_t now_us);
  void send_sdo(const SdoFrame& out) { parts_.outbox.push(0x580U + parts_.node, out); }
  void take_sync(const CanFrame& frame, std::uint32_t now_us);
  void sync(std::uint8_t counter, std::uint32_t now_us);
  void take_lss(const CanFrame& frame, std::uint32_t now_us);
  // During a change of bit rate nothing is sent, and frames that arrive are dropped.
  void stay_silent(std::uint32_t now_us);

  // ---- states ----

  void enter(NmtState state);
  void reset_node(std::uint32_t now_us);
  void reset_communication(std::uint32_t now_us);
  // Objects 1000h to 1FFFh as stored; the others keep their values.
  void load_communication();

  // ---- time ----

  void step(std::uint32_t now_us);
  void step_heartbeats(std::uint32_t now_us);
  void step_sync(std::uint32_t now_us);

  NodeObjects objects_{parts_};
  NodeParts parts_;
  BusWatch bus_{parts_};
  BitRateSwitch bit_rate_{parts_};
  NmtState state_ = NmtState::kInitialising;
};

}  // namespace slipstack::canopen
