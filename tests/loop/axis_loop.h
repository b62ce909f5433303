// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "firmware/control/tick.h"
#include "hal/host/board.h"
#include "sim_host/log/draw.h"
#include "sim_host/plant/end_stops.h"
#include "sim_host/plant/plant.h"
#include "sim_host/rng.h"
#include "sim_host/sensors/captured_switch.h"
#include "sim_host/sensors/coded_scale.h"
#include "sim_host/sensors/encoder.h"
#include "sim_host/sensors/reference_marks.h"
#include "sim_host/sensors/switches.h"

// The controller's tick and the simulated axis in one process. Nothing is shared between the two but the
// encoder's counts and the current.
namespace slipstack::loop {

inline constexpr double kTick_s = 1e-4;

/// What a mechatronics engineer would put into the controller for this axis: the virgin curve from
/// pre-sliding loops, as ten elements, here read off the axis's own curve and then spoiled: `level_error` on
/// all forces, `mass_error` on the mass. Slip distances are the encoder's, not the plant's.
inline ModelParameters identified_model(const sim::Axis& axis, double level_error, double mass_error) {
  ModelParameters model{};
  auto& inertia = std::get<EffectParameters<Inertia<float>, float>>(model);
  inertia.enabled = true;
  inertia.gains[0] = static_cast<float>(axis.mass_kg * (1.0 + mass_error));
  auto& hysteresis = std::get<EffectParameters<PreslidingHysteresis<float>, float>>(model);
  hysteresis.enabled = true;
  // Knots of a piecewise linear virgin curve: slopes between knots are sums of the stiffnesses beyond.
  constexpr std::array<double, kTargetElements + 1> kKnots_um = {0, 0.5, 1.5, 3, 5, 8, 12, 20, 40, 100, 400};
  std::array<double, kTargetElements + 1> slope{};
  for (std::size_t i = 0; i < kTargetElements; ++i) {
    const double a = kKnots_um[i] * 1e-6;
    const double b = kKnots_um[i + 1] * 1e-6;
    slope[i] = (axis.curve.force_N(b) - axis.curve.force_N(a)) / (b - a) * (1.0 + level_error);
  }
  for (std::size_t i = 0; i < kTargetElements; ++i) {
    hysteresis.shapes[i] = static_cast<float>(kKnots_um[i + 1] * 1e-6);
    hysteresis.gains[i] = static_cast<float>(std::max(0.0, slope[i] - slope[i + 1]));
  }
  return model;
}

/// Gains for the pick-and-place axis.
inline AxisParameters pick_and_place_parameters(const sim::Axis& axis) {
  AxisParameters p;
  p.encoder_resolution_m = static_cast<float>(axis.encoder_resolution_m);
  p.tick_s = static_cast<float>(kTick_s);
  p.motor_constant_N_per_A = static_cast<float>(axis.motor_constant_N_per_A);
  p.current_limit_A = static_cast<float>(axis.current_limit_A);
  p.velocity_limit_mps = 0.3F;
  p.acceleration_limit_mps2 = 5.0F;
  p.jerk_limit_mps3 = 200.0F;
  p.reference.absolute_encoder = true;
  return p;
}

class AxisLoop {
 public:
  explicit AxisLoop(const sim::Axis& axis, double start_m = 0.1)
      : plant(axis, start_m),
        encoder(axis.encoder_resolution_m, 0.37),
        noise_N_(axis.force_noise_N),
        rng_(5, "loop"),
        tick(board_encoder, motor, clock, watchdog, io) {
    clock.rate_Hz = 10'000'000;
    tick.set_period(1000);
    sense();
  }

  /// One tick of controller and plant.
  void step() {
    sense();
    tick.run();
    const double noise_N = noise_N_ > 0.0 ? noise_N_ * rng_.normal() : 0.0;
    const double stop_N = stops ? stops->force_N(plant.position_m(), plant.velocity_mps()) : 0.0;
    plant.step(current_A(), kTick_s, noise_N + stop_N + pushed_N);
    clock.advance(1000);
    ++ticks_;
  }
  /// Ticks, and the main loop after each.
  void run(double seconds) {
    const auto count = static_cast<std::int64_t>(std::llround(seconds / kTick_s));
    for (std::int64_t i = 0; i < count; ++i) {
      step();
      controller().poll();
    }
  }

  /// Through the state machine to operation enabled.
  bool enable() {
    for (const int word : {0x06, 0x07, 0x0F}) {
      controller().command(static_cast<std::uint16_t>(word));
      step();
      step();
    }
    // After some faults not before the axis stands.
    for (int i = 0; i < 5000 && controller().state().state() == DriveState::kSwitchedOn; ++i) step();
    return controller().state().state() == DriveState::kOperationEnabled;
  }

  Controller& controller() { return tick.controller(); }
  double time_s() const { return static_cast<double>(ticks_) * kTick_s; }
  /// Reference less true position, m; the encoder's phase taken out.
  double true_error_m() {
    const auto& out = controller().output();
    return static_cast<double>(out.position_error_m);
  }

  sim::Plant plant;
  sim::Encoder encoder;
  host::HostEncoder board_encoder;
  host::HostMotorCurrent motor;
  host::HostClock clock;
  host::HostWatchdog watchdog;
  host::HostDigitalIo io;
  host::HostEdgeCapture edges;  // of `captured`
  // What stands along the axis.
  std::optional<sim::Switches> switches;
  std::optional<sim::ReferenceMarks> marks;
  std::optional<sim::CodedScale> coded_marks;  // in place of them
  std::optional<sim::EndStops> stops;
  std::optional<sim::CapturedSwitch> captured;
  // Another encoder than one that counts: its reading in each tick.
  std::function<EncoderReading(std::int64_t counts)> reads;
  double pushed_N = 0.0;       // from outside, in the sense of the current
  std::size_t late_ticks = 0;  // after which a current acts; below kMostLate
  static constexpr std::size_t kMostLate = 8;

 private:
  void sense() {
    const double now_m = plant.position_m();
    if (reads) {
      board_encoder.next = reads(encoder.counts(now_m));
    } else {
      board_encoder.next.counts = static_cast<std::int32_t>(encoder.counts(now_m));
    }
    if (switches) io.inputs = switches->levels(now_m);
    if (captured) {
      constexpr std::uint32_t kBit = 1U << (sim::CapturedSwitch::kTerminal - 1U);
      io.inputs = (io.inputs & ~kBit) | captured->levels(now_m);
      edges.wired = sim::CapturedSwitch::kTerminal;
      captured->passed(encoder, last_m_, now_m, [this](std::int32_t counts, bool high) {
        edges.caught.push_back({counts, high});
      });
    }
    auto mark = marks ? marks->passed(encoder, last_m_, now_m) : std::nullopt;
    if (coded_marks) mark = coded_marks->passed(encoder, last_m_, now_m);
    if (mark) {
      board_encoder.index_passed = true;
      board_encoder.index_counts = *mark;
    }
    last_m_ = now_m;
  }

  // The current that acts now.
  double current_A() {
    const auto now = static_cast<std::size_t>(ticks_);
    commanded_A_[now % kMostLate] = motor.enabled ? static_cast<double>(motor.set_point_A) : 0.0;
    return now < late_ticks ? 0.0 : commanded_A_[(now - late_ticks) % kMostLate];
  }

  std::array<double, kMostLate> commanded_A_{};
  double noise_N_;
  sim::Rng rng_;
  std::int64_t ticks_ = 0;
  double last_m_ = plant.position_m();

 public:
  Tick<host::HostEncoder, host::HostMotorCurrent, host::HostClock, host::HostWatchdog, host::HostDigitalIo>
      tick;
};

}  // namespace slipstack::loop
