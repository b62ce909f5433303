// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>

#include "tests/can/bench.h"

// A carriage of 35 kg at 2 m/s, its drive, its brake and its end stop: where does it end, and with how much
// energy does it reach the stop?
namespace slipstack::energy {

inline constexpr double kMass_kg = 35.0;
inline constexpr double kSpeed_mps = 2.0;
inline constexpr double kTick_s = loop::kTick_s;
/// Deceleration and jerk of the quick stop: 2 m/s takes v^2 / 2d + v d / 2j = 143 mm.
inline constexpr double kDeceleration_mps2 = 15.0;
inline constexpr double kJerk_mps3 = 1500.0;
inline constexpr double kStop_m = kSpeed_mps * kSpeed_mps / (2.0 * kDeceleration_mps2) +
                                  kSpeed_mps * kDeceleration_mps2 / (2.0 * kJerk_mps3);
/// From the start of the carriage, at 0.
inline constexpr double kLimit_m = 1.0;                 ///< 607Dh:02
inline constexpr double kEndStop_m = 1.06;              ///< the last 60 mm are overtravel
inline constexpr double kSwitch_m = kEndStop_m - 0.16;  ///< where there is one: the way of a stop, and 17 mm
/// Assumed of a spring-applied rail clamp; its data sheet counts (docs/energy.md).
inline constexpr double kBrake_N = 700.0;
inline constexpr double kBrakeCloses_s = 0.04;
/// From the last refresh of the watchdog until its reset has pulled the outputs low (hal/stm32g474: 21.7 ms).
inline constexpr double kWatchdog_s = 0.0217;

/// What differs from a machine in order, from the instant of the fault on.
struct Failure {
  std::function<void(EncoderReading& reading)> encoder = [](EncoderReading&) {};
  std::function<void(host::HostMotorCurrent& motor, double since_s)> measurement = [](host::HostMotorCurrent&,
                                                                                      double) {};
  bool amplifier_dead = false;     ///< no force
  bool amplifier_reports = false;  ///< its fault input
  bool tick_dead = false;          ///< the processor hangs
  bool main_loop_dead = false;
  bool cable_pulled = false;  ///< nobody acknowledges what the node sends
  double push_N = 0.0;        ///< until the drive reacts
  double link_V = 48.0;       ///< of 36 to 60
};

/// What the master does; `since_s`: after the fault, negative before.
using Master = std::function<void(can::Bench& bench, double since_s)>;

class Machine {
 public:
  Machine(bool has_brake, bool has_limit) : has_brake_(has_brake) {
    bench_.axis.mass_kg = kMass_kg;
    bench_.axis.current_limit_A = 20.0;
    bench_.axis.motor_constant_N_per_A = 60.0;
    bench_.axis.encoder_resolution_m = 1e-6;
    bench_.axis.stroke_m = 3.0;
    bench_.axis.force_noise_N = 0.0;
    bench_.axis.effects = {};
    bench_.analogue = &analogue_;
    bench_.power_on();
    bench_.begin();
    zero_m_ = bench_.loop->plant.position_m();
    wire(has_limit);
  }

  can::Bench& bench() { return bench_; }
  double position_m() const { return bench_.loop->plant.position_m() - zero_m_; }
  double velocity_mps() const { return bench_.loop->plant.velocity_mps(); }
  /// Counts of a place.
  std::int32_t counts(double at_m) const {
    return static_cast<std::int32_t>(std::lround((at_m + zero_m_) / bench_.axis.encoder_resolution_m));
  }
  bool reacted() const {
    const DriveState state = bench_.loop->controller().state().state();
    return state != DriveState::kOperationEnabled;
  }
  bool switched() const { return with_switch_ && position_m() >= kSwitch_m; }
  void add_switch() { with_switch_ = true; }

  /// One tick, of the plant too; `failure` is nullptr as long as nothing has failed.
  void tick(const Failure* failure, double since_s) {
    loop::AxisLoop& loop = *bench_.loop;
    EncoderReading reading;
    reading.counts = static_cast<std::int32_t>(loop.encoder.counts(loop.plant.position_m()));
    if (failure != nullptr) failure->encoder(reading);
    loop.board_encoder.next = reading;
    // Limit switch and fault open, ready closes (2010h as below).
    const bool reports = failure != nullptr && failure->amplifier_reports;
    loop.io.inputs = (switched() ? 0U : 1U) | (reports ? 0U : 2U);
    if (failure != nullptr) failure->measurement(loop.motor, since_s);
    if (failure != nullptr) analogue_.bus_now.volts = static_cast<float>(0.05 * failure->link_V);
    if (failure == nullptr || !failure->tick_dead) {
      loop.tick.run();
      bench_.drive->after_tick();
    } else if (since_s > kWatchdog_s) {
      loop.motor.disable();
      loop.io.outputs = 0;
    }
    bench_.now_us += 100;
    if (failure != nullptr && failure->cable_pulled) bench_.device.bus.state = CanBusState::kPassive;
    if (failure == nullptr || (!failure->main_loop_dead && !failure->tick_dead)) bench_.poll();
    const bool powered = loop.motor.enabled && (failure == nullptr || !failure->amplifier_dead);
    double force_N = brake_N();
    if (failure != nullptr && !reacted()) force_N += failure->push_N;
    loop.plant.step(powered ? static_cast<double>(loop.motor.set_point_A) : 0.0, kTick_s, force_N);
    loop.clock.advance(1000);
  }

 private:
  void wire(bool has_limit) {
    constexpr std::array<std::uint32_t, 8> kWiring = {0, 1, 0, 0, 2, 1, 0x0003, 0};
    for (std::uint8_t sub = 1; sub <= 8; ++sub)
      EXPECT_EQ(bench_.write(0x2010, sub, kWiring[sub - 1U], sub < 7 ? 1 : 2), 0U);
    bench_.loop->io.inputs = 3;
    // An absolute encoder: software limits act where the position is known.
    EXPECT_EQ(bench_.write(0x2012, 1, 1, 1), 0U);
    bench_.configure();
    EXPECT_EQ(bench_.write_real(0x2000, 11, static_cast<float>(kSpeed_mps)), 0U);
    EXPECT_EQ(bench_.write_real(0x2000, 12, static_cast<float>(kDeceleration_mps2)), 0U);
    EXPECT_EQ(bench_.write_real(0x2000, 13, static_cast<float>(kJerk_mps3)), 0U);
    EXPECT_EQ(bench_.write_real(0x2000, 14, static_cast<float>(kDeceleration_mps2)), 0U);
    EXPECT_EQ(bench_.write_real(0x2000, 16, 25.0F), 0U);  // over-current
    EXPECT_EQ(bench_.write_real(0x2504, 6, 20.0F), 0U);
    EXPECT_EQ(bench_.write_real(0x2504, 7, 36.0F), 0U);
    EXPECT_EQ(bench_.write_real(0x2504, 8, 60.0F), 0U);
    EXPECT_EQ(bench_.write(0x2140, 3, bench_.read(0x2140, 1), 4), 0U);
    bench_.run_ms(2);
    EXPECT_EQ(bench_.write(0x6081, 0, 2000000, 4), 0U);
    EXPECT_EQ(bench_.write(0x6083, 0, 15000000, 4), 0U);
    EXPECT_EQ(bench_.write(0x6084, 0, 15000000, 4), 0U);
    EXPECT_EQ(bench_.write(0x60A4, 1, 1500000000, 4), 0U);
    if (has_limit) {
      EXPECT_EQ(bench_.write(0x607D, 2, static_cast<std::uint32_t>(counts(kLimit_m)), 4), 0U);
    }
    EXPECT_EQ(bench_.write(0x2408, 2, has_brake_ ? 40 : 0, 2), 0U);
  }

  // It closes some time after the output is low, and holds what stands.
  double brake_N() {
    const bool released = (bench_.loop->io.outputs & 1U) != 0;
    low_s_ = released ? 0.0 : low_s_ + kTick_s;
    if (!has_brake_ || low_s_ < kBrakeCloses_s) return 0.0;
    return std::clamp(-velocity_mps() * kMass_kg / kTick_s, -kBrake_N, kBrake_N);
  }

  host::HostAnalogueInputs analogue_;
  can::Bench bench_{false};
  bool has_brake_;
  bool with_switch_ = false;
  double zero_m_ = 0.0;
  double low_s_ = 0.0;
};

/// How it ended.
struct Outcome {
  double farthest_m = 0.0;  ///< beyond the software limit if positive; where no end stop is in the way
  double energy_J = 0.0;    ///< with which it reaches the end stop
  double peak_mps = 0.0;    ///< after the fault
  Fault fault = Fault::kNone;
};

}  // namespace slipstack::energy
