// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/canopen/network/outbox.h"
#include "firmware/canopen/objects/communication_objects.h"

namespace slipstack::canopen {

/// Sources of errors; each is there or not. The number is byte 3 of the message.
enum class ErrorSource : std::uint8_t {
  kDrive,
  kBusOff,
  kHeartbeat,
  kPdoLength,
  kOverrun,
  kPassive,
  kCollision,
  kSyncLength,
  kPdoTimeout,
  kHunting,
  kCount
};

/// The bits of the error register 1001h that an error code sets (CiA 301 tables 26 and 53).
constexpr std::uint8_t register_bits(std::uint16_t code) {
  switch (code >> 12) {
    case 0x2:
      return 0x03;
    case 0x3:
      return 0x05;
    case 0x4:
      return 0x09;
    case 0x8:
      return (code >> 8) == 0x81 || (code >> 8) == 0x82 ? 0x11 : 0x21;
    default:
      return 0x01;
  }
}

/// EMCY producer, error register and history (CiA 301, 7.2.7).
class Emergency {
 public:
  std::uint8_t error_register() const {
    std::uint8_t bits = 0;
    for (const std::uint16_t code : active_) bits |= code != 0 ? register_bits(code) : std::uint8_t{0};
    return bits;
  }
  std::uint8_t count() const { return count_; }
  /// The youngest is number 1.
  std::uint32_t history(std::uint8_t number) const { return number <= count_ ? history_[number - 1U] : 0; }
  void clear_history() { count_ = 0; }
  /// What begins anew with the communication: its errors are gone, and nothing is waiting to be sent.
  void reset_communication() {
    for (std::size_t i = 1; i < active_.size(); ++i) active_[i] = 0;
    waiting_count_ = 0;
    if (active_[0] != 0) queue(active_[0], ErrorSource::kDrive, 0);
  }

  /// The error of a source, 0 when it is gone. `detail`: the manufacturer's bytes.
  /// A change of detail, as a second lost node, is reported as well.
  void set(ErrorSource source, std::uint16_t code, std::uint32_t detail = 0) {
    std::uint16_t& active = active_[at(source)];
    if (active == code && (code == 0 || details_[at(source)] == detail)) return;
    active = code;
    details_[at(source)] = detail;
    if (code != 0) remember(code, source);
    // This error is gone, another one remains: the message carries the code of the latter.
    queue(code == 0 ? first_active() : code, source, detail);
  }

  /// Sends what is due; `inhibit_100us` between two messages.
  void step(std::uint32_t now_us, std::uint32_t cob, std::uint32_t inhibit_100us, Outbox& out) {
    if (waiting_count_ == 0 || (cob & kInvalidPdo) != 0 || out.room() == 0) return;
    if (sent_ && now_us - last_us_ < inhibit_100us * 100U) return;
    const Message& m = waiting_[first_];
    const std::array<std::uint8_t, 8> data = {static_cast<std::uint8_t>(m.code),
                                              static_cast<std::uint8_t>(m.code >> 8),
                                              m.bits,
                                              m.source,
                                              static_cast<std::uint8_t>(m.detail),
                                              static_cast<std::uint8_t>(m.detail >> 8),
                                              static_cast<std::uint8_t>(m.detail >> 16),
                                              static_cast<std::uint8_t>(m.detail >> 24)};
    out.push(cob & 0x7FF, data);
    first_ = (first_ + 1) % kWaiting;
    --waiting_count_;
    sent_ = true;
    last_us_ = now_us;
  }

 private:
  static constexpr std::size_t kWaiting = 8;
  struct Message {
    std::uint16_t code = 0;
    std::uint8_t bits = 0;
    std::uint8_t source = 0;
    std::uint32_t detail = 0;
  };
  static constexpr std::uint8_t at(ErrorSource source) { return static_cast<std::uint8_t>(source); }

  void queue(std::uint16_t code, ErrorSource source, std::uint32_t detail) {
    waiting_[(first_ + waiting_count_) % kWaiting] = {code, error_register(), at(source), detail};
    if (waiting_count_ < kWaiting) {
      ++waiting_count_;
    } else {
      first_ = (first_ + 1) % kWaiting;  // the oldest is dropped
    }
  }
  // The first of those that are left, 0 without one.
  std::uint16_t first_active() const {
    for (const std::uint16_t code : active_) {
      if (code != 0) return code;
    }
    return 0;
  }
  void remember(std::uint16_t code, ErrorSource source) {
    for (std::size_t i = kErrorHistory - 1; i > 0; --i) history_[i] = history_[i - 1];
    history_[0] = code | (static_cast<std::uint32_t>(at(source)) << 16);
    if (count_ < kErrorHistory) ++count_;
  }

  std::array<std::uint16_t, static_cast<std::size_t>(ErrorSource::kCount)> active_{};
  std::array<std::uint32_t, static_cast<std::size_t>(ErrorSource::kCount)> details_{};
  std::array<std::uint32_t, kErrorHistory> history_{};
  std::uint8_t count_ = 0;
  std::array<Message, kWaiting> waiting_{};
  std::size_t first_ = 0;
  std::size_t waiting_count_ = 0;
  std::uint32_t last_us_ = 0;
  bool sent_ = false;
};

}  // namespace slipstack::canopen
