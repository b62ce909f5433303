// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/node_parts.h"

namespace slipstack::canopen {

/// Watches the port: bus-off and its recovery, and the errors of frames (EMCY 8110h to 8250h).
class BusWatch {
 public:
  static constexpr std::uint32_t kBusOffWait_us = 100'000;  ///< before the port recovers
  /// How long a lost frame, or another node's frame with an identifier of this one, counts as an error.
  static constexpr std::uint32_t kEventHeld_us = 1'000'000;

  explicit BusWatch(NodeParts& parts) : parts_(parts) {}

  void reset() { frames_lost_ = parts_.port.status().frames_lost; }

  /// True when the bus has just been lost. A while later the port is asked to come back, which takes 128 x 11
  /// recessive bits (ISO 11898-1).
  bool lost_bus(std::uint32_t now_us) {
    const bool off = parts_.port.status().state == CanBusState::kOff;
    const bool was_off = bus_off_;
    bus_off_ = off;
    if (off && !was_off) {
      bus_off_us_ = now_us;
      count(parts_.bus_offs);
      parts_.outbox.clear();
      return true;
    }
    if (off && now_us - bus_off_us_ >= kBusOffWait_us) {
      bus_off_us_ = now_us;
      parts_.port.recover();
    }
    if (!off && was_off) {
      // 8140h: recovered from bus-off.
      parts_.emergency.set(ErrorSource::kBusOff, 0x8140);
      parts_.emergency.set(ErrorSource::kBusOff, 0);
    }
    return false;
  }

  /// Another node sends with an identifier of this one.
  void collision(std::uint32_t id, std::uint32_t now_us) {
    parts_.emergency.set(ErrorSource::kCollision, 0x8150, id);
    collision_us_ = now_us;
  }

  /// Once in every poll. `operational`: PDOs are expected. True when an RPDO has just failed to come.
  bool watch_frames(std::uint32_t now_us, bool operational) {
    Emergency& emergency = parts_.emergency;
    const CanBusStatus bus = parts_.port.status();
    // Events rather than states: the error is gone when there was none for a while. 8110h: CAN overrun.
    if (bus.frames_lost != frames_lost_) {
      frames_lost_ = bus.frames_lost;
      overrun_us_ = now_us;
      emergency.set(ErrorSource::kOverrun, 0x8110);
    } else if (now_us - overrun_us_ >= kEventHeld_us) {
      emergency.set(ErrorSource::kOverrun, 0);
    }
    // 8150h: CAN-ID collision.
    if (now_us - collision_us_ >= kEventHeld_us) emergency.set(ErrorSource::kCollision, 0);
    // 8120h: CAN in error passive mode.
    const bool passive = bus.state == CanBusState::kPassive;
    emergency.set(ErrorSource::kPassive, passive ? 0x8120 : 0);
    if (passive) parts_.application.unheard();
    // 8250h: RPDO time-out.
    const std::uint8_t late = operational ? parts_.pdos.late(now_us) : std::uint8_t{0};
    emergency.set(ErrorSource::kPdoTimeout, late != 0 ? 0x8250 : 0, late);
    const bool newly_late = late != 0 && !rpdo_late_;
    rpdo_late_ = late != 0;
    return newly_late;
  }

 private:
  NodeParts& parts_;
  bool bus_off_ = false;
  std::uint32_t bus_off_us_ = 0;
  std::uint32_t frames_lost_ = 0;
  std::uint32_t overrun_us_ = 0;
  std::uint32_t collision_us_ = 0;
  bool rpdo_late_ = false;
};

}  // namespace slipstack::canopen
