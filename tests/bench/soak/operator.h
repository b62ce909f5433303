// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/bench/soak/axis.h"
#include "tests/bench/soak/faults.h"

namespace slipstack::soak {

/// A master and its user, who change their mind: modes, moves, streams, halts, stops, NMT, at random times,
/// over a bus that may fail. It brings the axis back after a fault.
class Operator {
 public:
  Operator(SoakAxis& axis, sim::Rng& rng) : axis_(axis), rng_(rng) {}

  /// In every tick, before the drive's.
  void step(const BusState& bus, std::int64_t tick) {
    tick_ = tick;
    axis_.bench().device.bus.state = bus.bus_off ? CanBusState::kOff : axis_.bench().device.bus.state;
    if (!bus.silent) {
      if (tick % 200 == 0) post({0x77F, {0x05}}, bus);
      if (tick >= next_wish_) wish(bus);
      if (tick % 10 == 0) pursue(bus);
      if (tick % 20 == 0) stream(bus);
    }
    release(bus);
    while (axis_.bench().next()) {
    }
  }

  /// The controlword that reached the drive last, and when; by a frame that the main loop may not have seen
  /// yet.
  std::uint16_t delivered_word() const { return delivered_word_; }
  std::int64_t delivered_at() const { return delivered_at_; }
  /// When a controlword with bit 7 did.
  std::int64_t fault_reset_at() const { return fault_reset_at_; }
  std::uint8_t mode() const { return mode_; }
  std::string last_wish;
  std::array<std::uint32_t, 15> wishes{};

 private:
  using Frame = can::Message;

  void post(const Frame& frame, const BusState& bus) {
    if (bus.bus_off || rng_.chance(bus.lost)) return;
    waiting_.push_back(frame);
  }

  // What is not held back reaches the drive.
  void release(const BusState& bus) {
    if (bus.held) return;
    for (const Frame& frame : waiting_) {
      note(frame);
      axis_.bench().send(frame.id, frame.data);
    }
    waiting_.clear();
  }

  void note(const Frame& frame) {
    const bool by_sdo = frame.id == 0x605 && frame.data[1] == 0x40 && frame.data[2] == 0x60;
    // PDOs count in the NMT state operational only; whether they do is not known here.
    const bool by_pdo = (frame.id == 0x305 || frame.id == 0x205 || frame.id == 0x505) && nmt_ == 0x01;
    if (!by_sdo && !by_pdo) return;
    const std::size_t at = by_sdo ? 4 : 0;
    delivered_word_ = static_cast<std::uint16_t>(frame.data[at] | (frame.data[at + 1] << 8));
    delivered_at_ = tick_;
    if ((delivered_word_ & 0x80) != 0) fault_reset_at_ = tick_;
  }

  void write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes, const BusState& bus) {
    constexpr std::array<std::uint8_t, 5> kCommands = {0, 0x2F, 0x2B, 0x27, 0x23};
    can::Data data = can::Bench::address(kCommands[static_cast<std::size_t>(bytes)], index, sub);
    for (std::size_t i = 0; i < static_cast<std::size_t>(bytes); ++i)
      data[4 + i] = static_cast<std::uint8_t>(value >> (8 * i));
    post({0x605, data}, bus);
  }
  void controlword(std::uint32_t word, const BusState& bus) {
    word_ = static_cast<std::uint16_t>(word);
    write(0x6040, 0, word, 2, bus);
  }
  void set_mode(std::uint8_t mode, const BusState& bus) {
    mode_ = mode;
    streaming_ = false;
    write(0x6060, 0, mode, 1, bus);
  }
  std::int32_t position() { return axis_.controller().position().position_of(axis_.reading()); }
  // Counts from position zero: half of them beyond what is allowed.
  std::int32_t any_place() {
    const double span_m = rng_.chance(0.2) ? 0.6 : 0.0;
    const double place_m = rng_.uniform(kSoftware_m - span_m, kLength_m - kSoftware_m + span_m);
    return axis_.controller().position().position_of(axis_.counts_at(place_m));
  }

  // One step towards what is wanted.
  void pursue(const BusState& bus) {
    if (!wants_enabled_) return;
    switch (axis_.controller().state().state()) {
      case DriveState::kFault:
        // Somebody looks first, whether the carriage still moves or not.
        if (patience_ < 0) patience_ = static_cast<std::int64_t>(rng_.log_uniform(500.0, 5000.0));
        patience_ -= 10;
        if (patience_ >= 0) return;
        return controlword(word_ == 0x80 ? 0x00 : 0x80, bus);
      case DriveState::kSwitchOnDisabled:
        return controlword(0x06, bus);
      case DriveState::kReadyToSwitchOn:
        return controlword(0x07, bus);
      case DriveState::kSwitchedOn:
        return controlword(0x0F, bus);
      default:
        return;
    }
  }

  // Set-points of the cyclic modes, every 2 ms.
  void stream(const BusState& bus) {
    if (!streaming_) return;
    if (mode_ == 10)
      return write(0x6071, 0, static_cast<std::uint32_t>(static_cast<std::int32_t>(force_)), 2, bus);
    const double wanted_mps = rng_.chance(0.001) ? -wanted_mps_ : wanted_mps_;  // a leap, for one period
    const auto velocity = static_cast<std::uint32_t>(static_cast<std::int32_t>(wanted_mps / kResolution_m));
    if (mode_ == 3) return write(0x60FF, 0, velocity, 4, bus);
    const double change = 10.0 * 0.002;
    speed_mps_ += std::clamp(wanted_mps_ - speed_mps_, -change, change);
    target_ += speed_mps_ * 0.002 / kResolution_m;
    const auto place = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(target_)));
    const std::uint32_t bits = mode_ == 9 ? velocity : place;
    const auto word =
        axis_.controller().state().state() == DriveState::kOperationEnabled ? word_ : std::uint16_t{0x0F};
    if (wants_enabled_) {
      post({mode_ == 9 ? 0x505U : 0x305U,
            {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8),
             static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
             static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24)}},
           bus);
    }
    if (!bus.no_sync) post({0x080, {}}, bus);
  }

  // Something else.
  void wish(const BusState& bus) {
    next_wish_ = tick_ + static_cast<std::int64_t>(rng_.log_uniform(200.0, 20000.0));
    // What ends motion is followed by what brings it back.
    const bool idle = !wants_enabled_ || nmt_ != 0x01 || (word_ & 0x100) != 0 || mode_ == 0;
    const std::size_t what = idle && rng_.chance(0.7) ? 36 + 4 * rng_.below(2) : rng_.below(48);
    std::size_t kind = 0;
    if (what < 8) {
      kind = 0, move(bus);
    } else if (what < 14) {
      kind = 1, begin_stream(bus);
    } else if (what < 18) {
      kind = 2, begin_force(bus);
    } else if (what < 21) {
      kind = 3, home(bus);
    } else if (what < 24) {
      kind = 4, controlword(word_ ^ 0x100U, bus);  // halt, or its end
    } else if (what < 26) {
      kind = 5, controlword(0x0B, bus), wants_enabled_ = rng_.chance(0.7);  // quick stop
    } else if (what < 28) {
      kind = 6, controlword(rng_.pick({0x00U, 0x06U, 0x07U}), bus), wants_enabled_ = rng_.chance(0.7);
    } else if (what < 29) {
      kind = 7,
      manage(rng_.pick({std::uint8_t{0x02}, std::uint8_t{0x80}, std::uint8_t{0x81}, std::uint8_t{0x82}}),
             bus);
    } else if (what < 31) {
      kind = 8, write(0x6081, 0, static_cast<std::uint32_t>(rng_.log_uniform(1e5, 4e6)), 4, bus);
    } else if (what < 33) {
      kind = 9, write(0x6083, 0, static_cast<std::uint32_t>(rng_.log_uniform(1e6, 2e7)), 4, bus);
    } else if (what < 34) {
      kind = 10, set_mode(rng_.pick({std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{3}, std::uint8_t{6},
                                     std::uint8_t{8}, std::uint8_t{9}, std::uint8_t{10}}),
                          bus);
    } else if (what < 36) {
      kind = 11, wanted_mps_ = rng_.uniform(-1.2, 1.2) * axis_.build().speed_mps;
      if (rng_.chance(0.2)) target_ += rng_.sign() * rng_.log_uniform(1.0, 1e6);
    } else if (what < 40) {
      kind = 12, wants_enabled_ = true;
      manage(0x01, bus);
      if (axis_.controller().state().state() == DriveState::kOperationEnabled) controlword(0x0F, bus);
    } else if (what < 41) {
      wants_enabled_ = true;
      if (nmt_ != 0x01) manage(0x01, bus);
      move(bus);
    } else if (what < 44) {
      kind = 13, begin_velocity(3, bus);
    } else {
      kind = 14, begin_velocity(9, bus);
    }
    ++wishes[kind];
    constexpr std::array<const char*, 15> kNames = {"move",
                                                    "stream",
                                                    "force",
                                                    "home",
                                                    "halt",
                                                    "quick stop",
                                                    "disable",
                                                    "NMT",
                                                    "velocity",
                                                    "acceleration",
                                                    "mode only",
                                                    "stream's speed",
                                                    "enable",
                                                    "profile velocity",
                                                    "stream of velocities"};
    last_wish = kNames[kind];
  }

  void manage(std::uint8_t command, const BusState& bus) {
    nmt_ = command;
    if (command != 0x01) streaming_ = streaming_ && command == 0x80;
    post({0x000, {command, can::kNode}}, bus);
  }

  void move(const BusState& bus) {
    if (mode_ != 1) set_mode(1, bus);
    write(0x607A, 0, static_cast<std::uint32_t>(any_place()), 4, bus);
    controlword(0x0F, bus);
    controlword(rng_.chance(0.5) ? 0x3F : 0x1F, bus);
  }

  void begin_stream(const BusState& bus) {
    if (nmt_ != 0x01) manage(0x01, bus);
    set_mode(8, bus);
    controlword(0x0F, bus);
    target_ = static_cast<double>(position());
    speed_mps_ = 0.0;
    wanted_mps_ = rng_.uniform(-1.0, 1.0) * axis_.build().speed_mps;
    streaming_ = true;
  }

  // Profile velocity, or cyclic synchronous velocity.
  void begin_velocity(std::uint8_t mode, const BusState& bus) {
    if (nmt_ != 0x01) manage(0x01, bus);
    set_mode(mode, bus);
    controlword(0x0F, bus);
    wanted_mps_ = rng_.uniform(-1.2, 1.2) * axis_.build().speed_mps;
    streaming_ = true;
  }

  void begin_force(const BusState& bus) {
    set_mode(10, bus);
    force_ = rng_.uniform(-1000.0, 1000.0);
    streaming_ = true;
  }

  void home(const BusState& bus) {
    set_mode(6, bus);
    constexpr std::array<std::int8_t, 12> kMethods = {-4, -3, -2, -1, 1, 2, 7, 12, 17, 18, 24, 37};
    write(0x6098, 0, static_cast<std::uint8_t>(kMethods[rng_.below(kMethods.size())]), 1, bus);
    controlword(0x0F, bus);
    controlword(0x1F, bus);
    next_wish_ += rng_.chance(0.5) ? 40000 : 0;
  }

  SoakAxis& axis_;
  sim::Rng& rng_;
  std::int64_t tick_ = 0;
  std::int64_t next_wish_ = 0;
  std::vector<Frame> waiting_;
  bool wants_enabled_ = true;
  std::uint16_t word_ = 0;
  std::uint8_t mode_ = 0;
  std::uint8_t nmt_ = 0x80;
  bool streaming_ = false;
  std::int64_t patience_ = -1;  // ticks until the fault is reset
  double target_ = 0.0;
  double speed_mps_ = 0.0;
  double wanted_mps_ = 0.0;
  double force_ = 0.0;
  std::uint16_t delivered_word_ = 0;
  std::int64_t delivered_at_ = 0;
  std::int64_t fault_reset_at_ = -1000000;
};

}  // namespace slipstack::soak
