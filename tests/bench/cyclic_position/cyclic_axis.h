// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <tuple>

#include "tests/bench/cyclic_position/reference_watch.h"
#include "tests/can/bench.h"

// The drive on its bench, tick by tick, with an eye on every step of the reference.
namespace slipstack::bench {

class CyclicAxis {
 public:
  explicit CyclicAxis(std::uint32_t period_ms) {
    // Position limits act where the position is known.
    EXPECT_EQ(drive_.write(0x2012, 1, 1, 1), 0U);
    drive_.configure();
    EXPECT_EQ(drive_.write(0x60C2, 1, period_ms, 1), 0U);
    home_ = drive_.read_signed(0x6064, 0);
    mark();
  }

  /// One tick, and one turn of the main loop.
  void tick() {
    drive_.loop->step();
    drive_.drive->after_tick();
    drive_.now_us += 100;
    drive_.poll();
    ++ticks_;
    watch_.look(controller());
    while (drive_.next()) {
    }
  }
  /// RPDO 4: controlword and target velocity, with SYNC.
  void map_velocity() {
    constexpr std::uint32_t kId = 0x500U + can::kNode;
    for (const auto& [index, sub, value, bytes] : {std::tuple{0x1403, 1, 0x80000000U | kId, 4},
                                                   {0x1403, 2, 1U, 1},
                                                   {0x1603, 0, 0U, 1},
                                                   {0x1603, 1, 0x60400010U, 4},
                                                   {0x1603, 2, 0x60FF0020U, 4},
                                                   {0x1603, 0, 2U, 1},
                                                   {0x1403, 1, kId, 4}})
      EXPECT_EQ(drive_.write(static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub), value, bytes),
                0U);
  }
  void run_ms(int milliseconds) {
    for (int i = 0; i < 10 * milliseconds; ++i) tick();
  }
  /// Differences count from here on.
  void mark() { watch_.mark(controller()); }

  can::Bench& drive() { return drive_; }
  Controller& controller() { return drive_.loop->controller(); }
  double time_s() const { return static_cast<double>(ticks_) * loop::kTick_s; }
  std::int32_t home() const { return home_; }
  Fault fault() { return controller().state().faults().latched(); }
  double resolution_m() { return static_cast<double>(axis().encoder_resolution_m); }
  const AxisParameters& axis() { return controller().parameters().axis; }
  /// From home, m.
  double reference_m() {
    const ReferenceGenerator& reference = controller().reference();
    return (difference(reference.counts(), home_) + static_cast<double>(reference.fraction())) *
           resolution_m();
  }

 private:
  can::Bench drive_;
  std::int64_t ticks_ = 0;
  std::int32_t home_ = 0;
  ReferenceWatch watch_;

 public:
  Seen& seen = watch_.seen;
};

}  // namespace slipstack::bench
