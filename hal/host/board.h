// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "hal/include/analogue_inputs.h"
#include "hal/include/can_port.h"
#include "hal/include/clock.h"
#include "hal/include/digital_io.h"
#include "hal/include/edge_capture.h"
#include "hal/include/encoder.h"
#include "hal/include/indicator.h"
#include "hal/include/motor_current.h"
#include "hal/include/nonvolatile.h"
#include "hal/include/watchdog.h"

// A board in memory, for simulation and tests: the test writes what the firmware reads and reads what it
// wrote. Everything is public on purpose.
namespace slipstack::host {

struct HostEncoder {
  EncoderReading next;
  bool index_passed = false;  ///< since the last tick
  std::int32_t index_counts = 0;
  EncoderReading read() const { return next; }
  bool take_index(std::int32_t& counts) {
    if (!index_passed) return false;
    index_passed = false;
    counts = index_counts;
    return true;
  }
};

/// A motor whose current follows the set-point at once, unless `measurement_follows` is cleared.
struct HostMotorCurrent {
  float set_point_A = 0.0F;
  bool enabled = false;
  bool measurement_follows = true;
  CurrentReading measurement;

  void set(float current_A) {
    set_point_A = current_A;
    enabled = true;
    if (measurement_follows) measurement.current_A = current_A;
  }
  void disable() {
    set_point_A = 0.0F;
    enabled = false;
    if (measurement_follows) measurement.current_A = 0.0F;
  }
  CurrentReading measured() const { return measurement; }
};

/// Time passes only by advance(): runs are repeatable.
struct HostClock {
  std::uint32_t count = 0;
  std::uint32_t rate_Hz = 1'000'000;
  std::uint32_t now() const { return count; }
  std::uint32_t ticks_per_second() const { return rate_Hz; }
  void advance(std::uint32_t ticks) { count += ticks; }
};

struct HostWatchdog {
  std::uint32_t refreshed = 0;
  bool reset_by_watchdog = false;
  void refresh() { ++refreshed; }
  bool caused_last_reset() const { return reset_by_watchdog; }
};

struct HostDigitalIo {
  std::uint32_t inputs = 0;
  std::uint32_t outputs = 0;
  std::uint32_t read() const { return inputs; }
  void write(std::uint32_t levels) { outputs = levels; }
};

/// Both inputs are there; as they come up, 25 degC at 100 degC/V and 48 V at 20 V/V.
struct HostAnalogueInputs final : AnalogueInputs {
  bool temperature_wired = true;
  bool bus_wired = true;
  AnalogueReading temperature_now{0.25F, true};
  AnalogueReading bus_now{2.4F, true};

  bool has_temperature() const override { return temperature_wired; }
  bool has_bus_voltage() const override { return bus_wired; }
  AnalogueReading temperature() override { return temperature_now; }
  AnalogueReading bus_voltage() override { return bus_now; }
};

/// Edges that the test, or a simulated switch, has written.
struct HostEdgeCapture final : EdgeCapture {
  std::uint8_t wired = 0;
  std::deque<CapturedEdge> caught;

  std::uint8_t terminal() const override { return wired; }
  std::size_t take(std::span<CapturedEdge> edges) override {
    while (caught.size() > edges.size()) caught.pop_front();
    const std::size_t count = caught.size();
    std::copy(caught.begin(), caught.end(), edges.begin());
    caught.clear();
    return count;
  }
};

static_assert(Encoder<HostEncoder> && MotorCurrent<HostMotorCurrent> && Clock<HostClock> &&
              Watchdog<HostWatchdog> && DigitalIo<HostDigitalIo>);

/// One end of a CAN link; connect two and what one sends the other receives.
class HostCanPort final : public CanPort {
 public:
  explicit HostCanPort(std::size_t mailboxes = 32) : mailboxes_(mailboxes) {}
  void connect(HostCanPort& peer) {
    peer_ = &peer;
    peer.peer_ = this;
  }

  bool send(const CanFrame& frame) override {
    if (peer_ == nullptr || bus.state == CanBusState::kOff) return false;
    if (peer_->received_.size() >= peer_->mailboxes_) {
      ++peer_->bus.frames_lost;
      return true;
    }
    peer_->received_.push_back(frame);
    return true;
  }
  bool receive(CanFrame& frame) override {
    if (received_.empty()) return false;
    frame = received_.front();
    received_.pop_front();
    return true;
  }
  CanBusStatus status() const override { return bus; }
  void recover() override { bus.state = CanBusState::kActive; }
  bool offers_bit_rate(std::uint32_t bits_per_s) const override { return bits_per_s <= fastest; }
  bool set_bit_rate(std::uint32_t bits_per_s) override {
    if (!offers_bit_rate(bits_per_s)) return false;
    bit_rate = bits_per_s;
    return true;
  }

  CanBusStatus bus;
  std::uint32_t bit_rate = 0;  ///< 0: never set
  std::uint32_t fastest = 1'000'000;

 private:
  std::size_t mailboxes_;
  HostCanPort* peer_ = nullptr;
  std::deque<CanFrame> received_;
};

/// Flash in memory. When `bytes_until_power_fails` reaches zero, writing and erasing stop there, as they do
/// when the supply goes: the rest of the call changes nothing and every later one fails.
class HostNonvolatile final : public Nonvolatile {
 public:
  HostNonvolatile(std::size_t pages, std::size_t page_bytes, std::size_t unit)
      : page_bytes_(page_bytes), unit_(unit), bytes(pages * page_bytes, std::byte{0xFF}) {}

  std::size_t page_count() const override { return bytes.size() / page_bytes_; }
  std::size_t page_size() const override { return page_bytes_; }
  std::size_t write_unit() const override { return unit_; }

  NonvolatileStatus read(std::size_t page, std::size_t offset, std::span<std::byte> out) const override {
    if (!inside(page, offset, out.size())) return NonvolatileStatus::kOutOfRange;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(page * page_bytes_ + offset), out.size(),
                out.begin());
    return NonvolatileStatus::kOk;
  }

  NonvolatileStatus write(std::size_t page, std::size_t offset, std::span<const std::byte> data) override {
    if (!inside(page, offset, data.size())) return NonvolatileStatus::kOutOfRange;
    if (offset % unit_ != 0 || data.size() % unit_ != 0) return NonvolatileStatus::kMisaligned;
    std::byte* to = &bytes[page * page_bytes_ + offset];
    if (std::any_of(to, to + data.size(), [](std::byte b) { return b != std::byte{0xFF}; })) {
      return NonvolatileStatus::kNotErased;
    }
    for (const std::byte byte : data) {
      if (!powered()) return NonvolatileStatus::kDeviceError;
      *to++ = byte;
    }
    return NonvolatileStatus::kOk;
  }

  NonvolatileStatus erase(std::size_t page) override {
    if (page >= page_count()) return NonvolatileStatus::kOutOfRange;
    for (std::size_t i = 0; i < page_bytes_; ++i) {
      if (!powered()) return NonvolatileStatus::kDeviceError;
      bytes[page * page_bytes_ + i] = std::byte{0xFF};
    }
    return NonvolatileStatus::kOk;
  }

 private:
  bool inside(std::size_t page, std::size_t offset, std::size_t size) const {
    return page < page_count() && offset <= page_bytes_ && size <= page_bytes_ - offset;
  }
  bool powered() {
    if (bytes_until_power_fails == 0) return false;
    --bytes_until_power_fails;
    return true;
  }

  std::size_t page_bytes_;
  std::size_t unit_;

 public:
  std::vector<std::byte> bytes;
  std::size_t bytes_until_power_fails = static_cast<std::size_t>(-1);
};

class HostIndicator final : public Indicator {
 public:
  void show(Indication indication) override { shown = indication; }
  Indication shown = Indication::kStarting;
};

}  // namespace slipstack::host
