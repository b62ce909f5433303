// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/bench/real_time/buses.h"

namespace slipstack::bench {

/// A master that keeps a period: SDO between two of them, set-points and SYNC at their begin. Frames by CiA
/// 301, written out.
class ScriptMaster {
 public:
  static constexpr double kPeriod_s = 4e-3;
  static constexpr std::uint32_t kPositionPdo = 0x300U + can::kNode;  // RPDO 2 as delivered
  static constexpr std::uint32_t kOtherPdo = 0x500U + can::kNode;     // RPDO 4 by map()

  explicit ScriptMaster(Bus& bus) : bus_(bus) {}
  Lateness set_points;         ///< how late they were sent
  std::vector<double> late_s;  ///< the same, one by one
  /// Of the first one: periods since the begin.
  std::int64_t first_period() const { return period_ + 1 - static_cast<std::int64_t>(late_s.size()); }

  void write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, std::size_t bytes) {
    const std::array<std::uint8_t, 5> commands = {0, 0x2F, 0x2B, 0x27, 0x23};
    CanFrame request = sdo(commands[bytes], index, sub);
    for (std::size_t i = 0; i < bytes; ++i) request.data[4 + i] = static_cast<std::uint8_t>(value >> (8 * i));
    EXPECT_EQ(answer(request).data[0], 0x60) << std::hex << index << ':' << int{sub};
  }
  std::uint32_t read(std::uint16_t index, std::uint8_t sub) {
    const CanFrame response = answer(sdo(0x40, index, sub));
    EXPECT_EQ(response.data[0] & 0xE3, 0x43) << std::hex << index << ':' << int{sub};
    const std::size_t bytes = 4U - ((response.data[0] >> 2) & 3U);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= std::uint32_t{response.data[4 + i]} << (8 * i);
    return value;
  }
  std::int32_t read_signed(std::uint16_t index) { return static_cast<std::int32_t>(read(index, 0)); }

  void start_node() { send(0x000, {0x01, can::kNode}, 2); }
  void enable(std::uint8_t mode) {
    write(0x6060, 0, mode, 1);
    for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) write(0x6040, 0, word, 2);
    EXPECT_TRUE(reaches(0x6F, 0x27, 1.0)) << "operation enabled";
  }
  /// Whether the statusword has these bits within a time.
  bool reaches(std::uint32_t mask, std::uint32_t bits, double longest_s) {
    for (const double end_s = bus_.now_s() + longest_s; bus_.now_s() < end_s;) {
      if ((read(0x6041, 0) & mask) == bits) return true;
    }
    return false;
  }
  void pause(double seconds) {
    for (const double end_s = bus_.now_s() + seconds; bus_.now_s() < end_s;) next_period();
  }
  /// RPDO 4: controlword and one object more, with SYNC.
  void map(std::uint32_t mapping) {
    write(0x1403, 1, 0x80000000U | kOtherPdo, 4);
    write(0x1403, 2, 1, 1);
    write(0x1603, 0, 0, 1);
    write(0x1603, 1, 0x60400010U, 4);
    write(0x1603, 2, mapping, 4);
    write(0x1603, 0, 2, 1);
    write(0x1403, 1, kOtherPdo, 4);
  }
  /// A set-point in every period for so many seconds: `target(t)`, t by the master's own count of periods.
  template <class Target>
  void stream(std::uint32_t pdo, std::uint8_t bytes, double seconds, const Target& target) {
    const auto periods = static_cast<int>(std::lround(seconds / kPeriod_s));
    next_period();
    for (int n = 0; n < periods; ++n) {
      // Each in its turn: what is late follows at once.
      const double due_s = kPeriod_s * static_cast<double>(++period_);
      bus_.wait_until(due_s);
      late_s.push_back(bus_.now_s() - due_s);
      set_points.add(late_s.back());
      const auto bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(target(n * kPeriod_s)));
      std::array<std::uint8_t, 8> data = {0x0F, 0};
      for (std::size_t i = 0; i < bytes; ++i) data[2 + i] = static_cast<std::uint8_t>(bits >> (8 * i));
      send(pdo, data, static_cast<std::uint8_t>(2 + bytes));
      send(0x080, {}, 0);
      drain();
    }
  }

 private:
  static CanFrame sdo(std::uint8_t command, std::uint16_t index, std::uint8_t sub) {
    CanFrame frame;
    frame.id = 0x600 + can::kNode;
    frame.length = 8;
    frame.data = {command, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8), sub};
    return frame;
  }
  // Asked at the begin of a period, looked for at the begin of the next ones.
  CanFrame answer(const CanFrame& request) {
    drain();
    bus_.send(request);
    for (int i = 0; i < 500; ++i) {
      next_period();
      CanFrame frame;
      while (bus_.receive(frame)) {
        if (frame.id == 0x580 + can::kNode) return frame;
      }
    }
    ADD_FAILURE() << "no answer";
    return {};
  }
  void send(std::uint32_t id, const std::array<std::uint8_t, 8>& data, std::uint8_t length) {
    CanFrame frame;
    frame.id = id;
    frame.length = length;
    frame.data = data;
    bus_.send(frame);
  }
  void drain() {
    CanFrame frame;
    while (bus_.receive(frame)) {
    }
  }
  // Those that were missed are left out.
  void next_period() {
    period_ = std::max(period_ + 1, static_cast<std::int64_t>(bus_.now_s() / kPeriod_s));
    bus_.wait_until(kPeriod_s * static_cast<double>(period_));
  }

  Bus& bus_;
  std::int64_t period_ = 0;
};

}  // namespace slipstack::bench
