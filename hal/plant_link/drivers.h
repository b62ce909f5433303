// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/include/analogue_inputs.h"
#include "hal/include/clock.h"
#include "hal/include/digital_io.h"
#include "hal/include/edge_capture.h"
#include "hal/include/encoder.h"
#include "hal/include/motor_current.h"
#include "hal/include/watchdog.h"
#include "hal/plant_link/plant_link.h"

// The devices of the tick (hal/include) for a board whose plant is simulated at the other end of a PlantLink:
// an emulated board, or a board in the process of the host.
namespace slipstack {

class LinkEncoder {
 public:
  explicit LinkEncoder(PlantLink& link) : link_(link) {}
  EncoderReading read() const { return {link_.counts, 0, link_.encoder_valid != 0}; }
  bool take_index(std::int32_t& counts) {
    if (link_.index_sequence == indices_) return false;
    indices_ = link_.index_sequence;
    counts = link_.index_counts;
    return true;
  }

 private:
  PlantLink& link_;
  std::uint32_t indices_ = 0;
};

/// An ideal amplifier: the measurement is the set-point plus the offset that the host writes to inject an
/// error.
class LinkMotor {
 public:
  explicit LinkMotor(PlantLink& link) : link_(link) {}
  void set(float current_A) {
    set_point_A_ = current_A;
    link_.current_A = current_A;
    link_.driving = 1;
  }
  void disable() {
    set_point_A_ = 0.0F;
    link_.current_A = 0.0F;
    link_.driving = 0;
  }
  CurrentReading measured() const {
    return {set_point_A_ + link_.current_offset_A, link_.current_valid != 0};
  }

 private:
  PlantLink& link_;
  float set_point_A_ = 0.0F;
};

/// Time advances by one period per turn, plus the delay that the host writes to inject a late tick.
class LinkClock {
 public:
  explicit LinkClock(PlantLink& link) : link_(link) {}
  std::uint32_t now() const { return count_; }
  std::uint32_t ticks_per_second() const { return PlantLink::kClockTicks_Hz; }
  void turn() { count_ += link_.period + link_.late; }

 private:
  PlantLink& link_;
  std::uint32_t count_ = 0;
};

class LinkWatchdog {
 public:
  explicit LinkWatchdog(PlantLink& link) : link_(link) {}
  void refresh() { link_.watchdog_refreshed = link_.watchdog_refreshed + 1; }
  bool caused_last_reset() const { return false; }

 private:
  PlantLink& link_;
};

class LinkDigitalIo {
 public:
  explicit LinkDigitalIo(PlantLink& link) : link_(link) {}
  std::uint32_t read() const { return link_.digital_inputs; }
  void write(std::uint32_t levels) { link_.digital_outputs = levels; }

 private:
  PlantLink& link_;
};

class LinkAnalogueInputs final : public AnalogueInputs {
 public:
  explicit LinkAnalogueInputs(PlantLink& link) : link_(link) {}
  bool has_temperature() const override { return true; }
  bool has_bus_voltage() const override { return true; }
  AnalogueReading temperature() override { return {link_.temperature_V, link_.analogue_valid != 0}; }
  AnalogueReading bus_voltage() override { return {link_.bus_V, link_.analogue_valid != 0}; }

 private:
  PlantLink& link_;
};

class LinkEdgeCapture final : public EdgeCapture {
 public:
  explicit LinkEdgeCapture(PlantLink& link) : link_(link) {}
  std::uint8_t terminal() const override { return static_cast<std::uint8_t>(link_.edge_terminal); }
  std::size_t take(std::span<CapturedEdge> edges) override {
    const std::uint32_t last = link_.edge_sequence;
    std::uint32_t count = last - taken_;
    for (const std::size_t most : {kKept, edges.size()}) {
      if (count > most) count = static_cast<std::uint32_t>(most);
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t behind = count - 1 - i;  // 0: the last one
      edges[i] = {link_.edge_counts[(last - behind) % PlantLink::kEdges],
                  (link_.edge_high != 0) == (behind % 2 == 0)};
    }
    taken_ = last;
    return count;
  }

 private:
  static_assert(kKept < PlantLink::kEdges);

  PlantLink& link_;
  std::uint32_t taken_ = 0;
};

/// All of them on one link, as a board has them. The link must outlive this.
class LinkDevices {
 public:
  explicit LinkDevices(PlantLink& link)
      : link_(link),
        encoder_(link),
        motor_(link),
        clock_(link),
        watchdog_(link),
        io_(link),
        analogue_(link),
        edges_(link) {}

  PlantLink& link() { return link_; }
  LinkEncoder& encoder() { return encoder_; }
  LinkMotor& motor_current() { return motor_; }
  LinkClock& clock() { return clock_; }
  LinkWatchdog& watchdog() { return watchdog_; }
  LinkDigitalIo& digital_io() { return io_; }
  AnalogueInputs& analogue_inputs() { return analogue_; }
  EdgeCapture& edge_capture() { return edges_; }
  std::uint32_t tick_period() const { return 0; }

 private:
  PlantLink& link_;
  LinkEncoder encoder_;
  LinkMotor motor_;
  LinkClock clock_;
  LinkWatchdog watchdog_;
  LinkDigitalIo io_;
  LinkAnalogueInputs analogue_;
  LinkEdgeCapture edges_;
};

static_assert(Encoder<LinkEncoder> && MotorCurrent<LinkMotor> && Clock<LinkClock> && Watchdog<LinkWatchdog> &&
              DigitalIo<LinkDigitalIo>);

}  // namespace slipstack
