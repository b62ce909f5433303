// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/canopen/objects/object.h"
#include "hal/include/can_port.h"

namespace slipstack::canopen {

/// LSS slave (CiA 305): node id and bit rate over the bus. What is set waits until it is stored, and
/// activated by a reset of communication (node id) or the activation command (bit rate).
class Lss {
 public:
  static constexpr std::uint32_t kRequest = 0x7E5;
  static constexpr std::uint32_t kResponse = 0x7E4;
  static constexpr std::uint8_t kUnconfigured = 0xFF;

  /// What the node does after a request.
  enum class Wish : std::uint8_t { kNothing, kStore, kActivateBitRate };
  /// Bits per second by index (CiA 305 table 1); 0: reserved.
  static constexpr std::array<std::uint32_t, 9> kBitRates = {1'000'000, 800'000, 500'000, 250'000, 125'000,
                                                             0,         50'000,  20'000,  10'000};
  static constexpr std::uint32_t bits_per_s(std::uint8_t index) {
    return index < kBitRates.size() ? kBitRates[index] : 0;
  }
  struct Identity {
    std::array<std::uint32_t, 4> words{};  ///< vendor, product, revision, serial
  };

  bool configuring() const { return configuring_; }
  std::uint8_t node() const { return node_; }
  std::uint8_t bit_rate() const { return bit_rate_; }
  std::uint16_t switch_delay_ms() const { return delay_ms_; }
  void begin(std::uint8_t node, std::uint8_t bit_rate) {
    node_ = node;
    bit_rate_ = bit_rate;
    configuring_ = false;
    selected_ = 0;
    identified_ = 0;
    fast_ = 0;
  }

  /// What the node is and allows: `writable` false when the access lock is closed, `port` for the bit rates.
  struct Device {
    Identity identity;
    std::uint8_t active_node;
    bool writable;
    const CanPort& port;
  };

  /// A request of 8 bytes; true: `out` is the response.
  bool receive(std::span<const std::uint8_t, 8> in, const Device& device, std::array<std::uint8_t, 8>& out,
               Wish& wish) {
    const Identity& identity = device.identity;
    const std::uint8_t active_node = device.active_node;
    out = {in[0], 0, 0, 0, 0, 0, 0, 0};
    wish = Wish::kNothing;
    const std::uint32_t word = number(in.subspan(1, 4));
    switch (in[0]) {
      case 0x04:
        if (in[1] <= 1) configuring_ = in[1] == 1;
        return false;
      case 0x40:
      case 0x41:
      case 0x42:
      case 0x43:
        return select(static_cast<std::uint8_t>(in[0] - 0x40), word, identity, out);
      case 0x46:
      case 0x47:
      case 0x48:
      case 0x49:
      case 0x4A:
      case 0x4B:
        return identify(static_cast<std::uint8_t>(in[0] - 0x46), word, identity, out);
      case 0x4C:
        out[0] = 0x50;
        return active_node == kUnconfigured && !configuring_;
      case 0x51:
        return fast_scan(in, word, identity, active_node, out);
      default:
        return configuring_ && configure(in, device, out, wish);
    }
  }

 private:
  static std::uint32_t number(std::span<const std::uint8_t> bytes) {
    return bytes[0] | (static_cast<std::uint32_t>(bytes[1]) << 8) |
           (static_cast<std::uint32_t>(bytes[2]) << 16) | (static_cast<std::uint32_t>(bytes[3]) << 24);
  }

  // Four messages, each with one word of the identity, in this order.
  bool select(std::uint8_t part, std::uint32_t word, const Identity& identity,
              std::array<std::uint8_t, 8>& out) {
    selected_ = part == selected_ && word == identity.words[part] ? static_cast<std::uint8_t>(selected_ + 1)
                                                                  : std::uint8_t{0};
    if (part == 0 && selected_ == 0 && word == identity.words[0]) selected_ = 1;
    if (selected_ < 4) return false;
    selected_ = 0;
    configuring_ = true;
    out = {0x44, 0, 0, 0, 0, 0, 0, 0};
    return true;
  }

  // LSS identify remote slave: six messages in this order, vendor and product, revision and serial number as
  // the lowest and the highest that are meant.
  bool identify(std::uint8_t part, std::uint32_t word, const Identity& identity,
                std::array<std::uint8_t, 8>& out) {
    const std::uint32_t own = identity.words[part < 2 ? part : 2U + (part - 2U) / 2U];
    const bool fits = part < 2 ? word == own : (part % 2 == 0 ? word <= own : word >= own);
    if (part == 0) identified_ = 0;
    identified_ = part == identified_ && fits ? static_cast<std::uint8_t>(part + 1) : std::uint8_t{0};
    if (identified_ < 6) return false;
    identified_ = 0;
    out = {0x4F, 0, 0, 0, 0, 0, 0, 0};
    return true;
  }

  // LSS fastscan: a node without an id confirms that the upper bits of a word are its own.
  bool fast_scan(std::span<const std::uint8_t, 8> in, std::uint32_t word, const Identity& identity,
                 std::uint8_t active_node, std::array<std::uint8_t, 8>& out) {
    if (active_node != kUnconfigured || configuring_) return false;
    const std::uint8_t bit = in[5];
    const std::uint8_t part = in[6];
    const std::uint8_t next = in[7];
    out = {0x4F, 0, 0, 0, 0, 0, 0, 0};
    if (bit == 0x80) {
      fast_ = 0;
      return true;
    }
    if (bit > 31 || part > 3 || next > 3 || part != fast_) return false;
    if (((word ^ identity.words[part]) >> bit) != 0) return false;
    if (bit == 0) {
      fast_ = next;
      if (part == 3 && next < part) configuring_ = true;
    }
    return true;
  }

  bool configure(std::span<const std::uint8_t, 8> in, const Device& device, std::array<std::uint8_t, 8>& out,
                 Wish& wish) {
    const bool writable = device.writable;
    switch (in[0]) {
      case 0x11:
        if (!writable || !((in[1] >= 1 && in[1] <= 127) || in[1] == kUnconfigured)) {
          out[1] = 1;
        } else {
          node_ = in[1];
        }
        return true;
      case 0x13:
        // Table 0 is CiA 305's; what the port does not offer is refused here, before anybody switches.
        if (!writable || in[1] != 0 || bits_per_s(in[2]) == 0 ||
            !device.port.offers_bit_rate(bits_per_s(in[2]))) {
          out[1] = 1;
        } else {
          bit_rate_ = in[2];
        }
        return true;
      case 0x15:
        delay_ms_ = static_cast<std::uint16_t>(in[1] | (in[2] << 8));
        if (writable) wish = Wish::kActivateBitRate;
        return false;
      case 0x17:
        out[1] = writable ? 0 : 1;
        if (writable) wish = Wish::kStore;  // the node changes the answer to an error if storing fails
        return true;
      case 0x5A:
      case 0x5B:
      case 0x5C:
      case 0x5D:
        for (std::size_t i = 0; i < 4; ++i) {
          out[1 + i] = static_cast<std::uint8_t>(device.identity.words[in[0] - 0x5AU] >> (8 * i));
        }
        return true;
      case 0x5E:
        out[1] = device.active_node;
        return true;
      default:
        return false;
    }
  }

  bool configuring_ = false;
  std::uint8_t selected_ = 0;
  std::uint8_t identified_ = 0;
  std::uint8_t fast_ = 0;
  std::uint8_t node_ = kUnconfigured;
  std::uint8_t bit_rate_ = 3;
  std::uint16_t delay_ms_ = 0;
};

}  // namespace slipstack::canopen
