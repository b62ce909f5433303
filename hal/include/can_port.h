// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace slipstack {

/// A classic CAN frame (ISO 11898-1).
struct CanFrame {
  std::uint32_t id = 0;     ///< 11 bits, or 29 if `extended`
  std::uint8_t length = 0;  ///< 0 to 8
  bool extended = false;
  bool remote = false;  ///< a request: no data
  std::array<std::uint8_t, 8> data{};

  friend bool operator==(const CanFrame&, const CanFrame&) = default;
};

enum class CanBusState : std::uint8_t { kActive, kWarning, kPassive, kOff };

/// What happened on the bus since the start; counts saturate at their largest value.
struct CanBusStatus {
  CanBusState state = CanBusState::kActive;
  std::uint16_t transmit_errors = 0;
  std::uint16_t receive_errors = 0;
  std::uint32_t frames_lost = 0;  ///< received, but the queue was full
};

/// One CAN port, used outside the tick. No call waits.
class CanPort {
 public:
  /// Queues a frame. False when every mailbox is full: try again later.
  virtual bool send(const CanFrame& frame) = 0;
  /// Takes the oldest frame received. False when there is none.
  virtual bool receive(CanFrame& frame) = 0;
  virtual CanBusStatus status() const = 0;
  /// Leaves bus-off; the port takes part again after 128 x 11 recessive bits.
  virtual void recover() = 0;
  /// Whether this port can change to a bit rate by itself. A port of an operating system cannot.
  virtual bool offers_bit_rate(std::uint32_t) const { return false; }
  /// Leaves the bus, changes the bit rate, joins again: some milliseconds at most, frames that wait are given
  /// up. False: nothing has changed.
  virtual bool set_bit_rate(std::uint32_t) { return false; }

 protected:
  ~CanPort() = default;
};

}  // namespace slipstack
