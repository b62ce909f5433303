// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/can/bench.h"

// The drive on its bench, tick by tick, with an eye on every step of the reference.
namespace slipstack::bench {

/// What the reference did, in SI units.
struct Seen {
  double velocity_mps = 0.0;       ///< largest difference of two positions
  double acceleration_mps2 = 0.0;  ///< largest difference of two velocities
  double jerk_mps3 = 0.0;          ///< largest difference of two accelerations
  double error_m = 0.0;            ///< largest following error
  double square_error = 0.0;
  std::int64_t ticks = 0;
  double rms_error_m() const {
    return std::sqrt(square_error / static_cast<double>(std::max<std::int64_t>(ticks, 1)));
  }
};

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
    look();
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
  void mark() {
    const Controller& controller = drive_.loop->controller();
    last_ = controller.reference().counts();
    last_fraction_ = static_cast<double>(controller.reference().fraction());
    if (controller.reference().standing()) last_step_ = last_change_ = 0.0;
    seen = {};
  }

  can::Bench& drive() { return drive_; }
  Controller& controller() { return drive_.loop->controller(); }
  double time_s() const { return static_cast<double>(ticks_) * loop::kTick_s; }
  std::int32_t home() const { return home_; }
  Fault fault() { return controller().state().faults().latched(); }
  double resolution_m() { return static_cast<double>(axis().encoder_resolution_m); }
  const AxisParameters& axis() { return controller().parameters().axis; }
  /// From home, m.
  double reference_m() {
    return (static_cast<double>(difference(controller().reference().counts(), home_)) + last_fraction_) *
           resolution_m();
  }
  Seen seen;

 private:
  void look() {
    const ReferenceGenerator& reference = controller().reference();
    const auto fraction = static_cast<double>(reference.fraction());
    const double step =
        static_cast<double>(difference(reference.counts(), last_)) + fraction - last_fraction_;
    const double per_tick = resolution_m() / loop::kTick_s;
    seen.velocity_mps = std::max(seen.velocity_mps, std::abs(step) * per_tick);
    seen.acceleration_mps2 =
        std::max(seen.acceleration_mps2, std::abs(step - last_step_) * per_tick / loop::kTick_s);
    const double change = step - last_step_;
    seen.jerk_mps3 = std::max(seen.jerk_mps3,
                              std::abs(change - last_change_) * per_tick / (loop::kTick_s * loop::kTick_s));
    last_change_ = change;
    const auto error_m = static_cast<double>(controller().output().position_error_m);
    seen.error_m = std::max(seen.error_m, std::abs(error_m));
    seen.square_error += error_m * error_m;
    ++seen.ticks;
    last_ = reference.counts();
    last_fraction_ = fraction;
    last_step_ = step;
  }

  can::Bench drive_;
  std::int64_t ticks_ = 0;
  std::int32_t home_ = 0;
  std::int32_t last_ = 0;
  double last_fraction_ = 0.0;
  double last_step_ = 0.0;
  double last_change_ = 0.0;
};

}  // namespace slipstack::bench
