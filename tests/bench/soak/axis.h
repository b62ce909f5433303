// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/can/bench.h"

// A carriage of 35 kg between two end stops, with limit switches, a home switch and a brake, its drive and
// its node, and everything about them that can fail.
namespace slipstack::soak {

inline constexpr double kTick_s = loop::kTick_s;
inline constexpr double kMass_kg = 35.0;
inline constexpr double kResolution_m = 1e-6;
inline constexpr double kDeceleration_mps2 = 15.0;  ///< of every stop, and the largest acceleration
inline constexpr double kJerk_mps3 = 1500.0;
inline constexpr double kCurrent_A = 20.0;
inline constexpr double kStall_A = 1.0;  ///< five times what the friction of this axis needs
inline constexpr double kBrake_N = 700.0;
inline constexpr double kBrakeCloses_s = 0.04;
/// The end stops are at 0 and at kLength_m. A switch is so far from its stop that the axis stops in between
/// from 2 m/s: 143 mm, and 17 mm more; a software limit stands before it.
inline constexpr double kLength_m = 2.0;
inline constexpr double kSwitch_m = 0.16;
inline constexpr double kSoftware_m = 0.18;

/// What an axis of the soak is built like; drawn anew for each.
struct Build {
  double speed_mps = 2.0;
  bool absolute_encoder = true;
  bool brake = true;
  std::uint32_t brake_release_ms = 0;
  std::uint32_t quick_stop_option = 2;  ///< 605Ah
  std::uint32_t shutdown_option = 0;    ///< 605Bh
  std::uint32_t disable_option = 1;     ///< 605Ch
  std::uint32_t halt_option = 1;        ///< 605Dh
  std::uint32_t fault_option = 2;       ///< 605Eh
};

/// 2504h: limits of the motor's temperature and of the DC link.
inline constexpr double kWarning_C = 80.0;
inline constexpr double kHot_C = 100.0;
inline constexpr double kLowest_V = 36.0;
inline constexpr double kLink_V = 48.0;
inline constexpr double kHighest_V = 60.0;

/// What is broken in this tick.
struct Broken {
  enum class Encoder : std::uint8_t { kWell, kReversed, kStuck, kLosesCounts, kInvalid };
  enum class Switch : std::uint8_t { kWell, kOpen, kClosed, kBounces };
  Encoder encoder = Encoder::kWell;
  std::int32_t jump_counts = 0;  ///< in this tick
  bool index_noise = false;      ///< an index where none is
  bool current_invalid = false;
  bool current_false = false;  ///< the measurement says 0
  bool over_current = false;   ///< the measurement says too much
  bool amplifier_fault = false;
  bool amplifier_not_ready = false;
  bool amplifier_dead = false;  ///< no force, and it does not say so
  Switch negative = Switch::kWell;
  Switch positive = Switch::kWell;
  Switch home = Switch::kWell;
  bool tick_late = false;
  bool main_loop_dead = false;
  double temperature_C = 40.0;
  double link_V = kLink_V;
  bool temperature_invalid = false;  ///< its wire is broken

  /// Below it the amplifier makes no force.
  bool link_dead() const { return link_V < 0.5 * kLowest_V; }
};

class SoakAxis {
 public:
  explicit SoakAxis(const Build& build) : build_(build) {
    bench_.axis.mass_kg = kMass_kg;
    bench_.axis.current_limit_A = kCurrent_A;
    bench_.axis.motor_constant_N_per_A = 60.0;
    bench_.axis.encoder_resolution_m = kResolution_m;
    bench_.axis.stroke_m = kLength_m;
    bench_.axis.force_noise_N = 0.0;
    bench_.axis.effects = {};
    bench_.analogue = &analogue_;
    bench_.power_on();
    bench_.begin();
    loop::AxisLoop& loop = *bench_.loop;
    loop.plant.reset(0.5 * kLength_m);
    loop.switches = sim::Switches{.negative_m = kSwitch_m,
                                  .positive_m = kLength_m - kSwitch_m,
                                  .home_begin_m = 0.8,
                                  .home_end_m = 0.82};
    loop.marks = sim::ReferenceMarks{.first_m = 0.0043, .distance_m = 0.02};
    last_true_ = true_counts();
    reading_ = last_true_;
    loop.board_encoder.next = {.counts = reading_};
    loop.io.inputs = loop.switches->levels(position_m());
    wire();
  }

  can::Bench& bench() { return bench_; }
  Controller& controller() { return bench_.loop->controller(); }
  const Build& build() const { return build_; }
  const host::HostMotorCurrent& motor() const { return bench_.loop->motor; }
  double position_m() const { return bench_.loop->plant.position_m(); }
  double velocity_mps() const { return bench_.loop->plant.velocity_mps(); }
  double energy_J() const { return 0.5 * kMass_kg * velocity_mps() * velocity_mps(); }
  bool in_stop() const { return position_m() < 0.0 || position_m() > kLength_m; }
  std::int32_t reading() const { return reading_; }
  /// Where on the rail the axis is if the encoder reads so.
  double place_m(std::int32_t counts) const {
    return position_m() + static_cast<double>(difference(counts, reading_)) * kResolution_m;
  }
  std::int32_t counts_at(double place_m) const {
    return sum(reading_, static_cast<std::int32_t>(std::lround((place_m - position_m()) / kResolution_m)));
  }

  /// One tick of the drive, of its main loop if `turn`, and of the machine.
  void tick(const Broken& broken, sim::Rng& rng, bool turn) {
    loop::AxisLoop& loop = *bench_.loop;
    sense(broken, rng);
    measure(broken);
    if (broken.tick_late) loop.clock.advance(800);
    loop.tick.run();
    bench_.drive->after_tick();
    bench_.now_us += 100;
    if (turn && !broken.main_loop_dead) {
      bench_.poll();
      loop.tick.main_loop_ran();
    }
    const bool powered =
        loop.motor.enabled && !broken.amplifier_dead && !broken.amplifier_fault && !broken.link_dead();
    loop.plant.step(powered ? static_cast<double>(loop.motor.set_point_A) : 0.0, kTick_s,
                    brake_N() + stop_N());
    loop.clock.advance(1000);
  }

 private:
  std::int32_t true_counts() const {
    return static_cast<std::int32_t>(bench_.loop->encoder.counts(position_m()));
  }

  void sense(const Broken& broken, sim::Rng& rng) {
    loop::AxisLoop& loop = *bench_.loop;
    const std::int32_t now = true_counts();
    const std::int32_t step = now - last_true_;
    using enum Broken::Encoder;
    // An absolute encoder that works again knows its place; an incremental one goes on from where it is.
    if (broken.encoder == kWell && build_.absolute_encoder) {
      reading_ = now;
    } else if (broken.encoder == kReversed) {
      reading_ = difference(reading_, step);
    } else if (broken.encoder == kWell || (broken.encoder == kLosesCounts && rng.chance(0.9))) {
      reading_ = sum(reading_, step);
    }
    reading_ = sum(reading_, broken.jump_counts);
    loop.board_encoder.next = {.counts = reading_, .valid = broken.encoder != kInvalid};
    sense_marks(broken, now);
    sense_switches(broken, rng);
    last_true_ = now;
  }

  void sense_marks(const Broken& broken, std::int32_t now) {
    loop::AxisLoop& loop = *bench_.loop;
    const double before_m = position_m() - static_cast<double>(now - last_true_) * kResolution_m;
    const auto mark = loop.marks->passed(loop.encoder, before_m, position_m());
    if (!mark && !broken.index_noise) return;
    loop.board_encoder.index_passed = true;
    loop.board_encoder.index_counts = mark ? sum(reading_, *mark - now) : reading_;
  }

  void sense_switches(const Broken& broken, sim::Rng& rng) {
    sim::Switches& switches = *bench_.loop->switches;
    switches.amplifier_ready = !broken.amplifier_not_ready;
    switches.amplifier_fault = broken.amplifier_fault;
    std::uint32_t levels = switches.levels(position_m());
    const auto broken_switch = [&](Broken::Switch how, std::uint32_t bit) {
      if (how == Broken::Switch::kOpen) levels &= ~bit;
      if (how == Broken::Switch::kClosed) levels |= bit;
      if (how == Broken::Switch::kBounces && rng.chance(0.3)) levels ^= bit;
    };
    broken_switch(broken.negative, 1);
    broken_switch(broken.positive, 2);
    broken_switch(broken.home, 4);
    bench_.loop->io.inputs = levels;
  }

  void measure(const Broken& broken) {
    host::HostMotorCurrent& motor = bench_.loop->motor;
    motor.measurement_follows = true;
    motor.measurement = {motor.set_point_A, !broken.current_invalid};
    if (broken.current_false) motor.measurement.current_A = 0.0F;
    if (broken.over_current) motor.measurement.current_A = 30.0F;
    analogue_.temperature_now = {static_cast<float>(0.01 * (broken.temperature_C + 50.0)),
                                 !broken.temperature_invalid};
    analogue_.bus_now = {static_cast<float>(0.05 * broken.link_V), true};
  }

  double stop_N() const {
    constexpr sim::EndStops kStops{.negative_m = 0.0, .positive_m = kLength_m};
    return kStops.force_N(position_m(), velocity_mps());
  }

  // It closes some time after the output is low, and holds what stands.
  double brake_N() {
    const bool released = (bench_.loop->io.outputs & 1U) != 0;
    low_s_ = released ? 0.0 : low_s_ + kTick_s;
    if (!build_.brake || low_s_ < kBrakeCloses_s) return 0.0;
    return std::clamp(-velocity_mps() * kMass_kg / kTick_s, -kBrake_N, kBrake_N);
  }

  void wire() {
    for (std::uint8_t sub = 1; sub <= 8; ++sub)
      EXPECT_EQ(bench_.write(0x2010, sub, sim::Switches::kWiring[sub], sub < 7 ? 1 : 2), 0U);
    EXPECT_EQ(bench_.write(0x2012, 1, build_.absolute_encoder ? 1 : 0, 1), 0U);
    bench_.configure();
    EXPECT_EQ(bench_.write_real(0x2000, 11, static_cast<float>(build_.speed_mps)), 0U);
    EXPECT_EQ(bench_.write_real(0x2000, 12, static_cast<float>(kDeceleration_mps2)), 0U);
    EXPECT_EQ(bench_.write_real(0x2000, 13, static_cast<float>(kJerk_mps3)), 0U);
    EXPECT_EQ(bench_.write_real(0x2000, 14, static_cast<float>(kDeceleration_mps2)), 0U);
    EXPECT_EQ(bench_.write_real(0x2000, 16, 25.0F), 0U);  // over-current
    EXPECT_EQ(bench_.write_real(0x2000, 19, static_cast<float>(kStall_A)), 0U);
    const std::array<double, 8> limits = {100.0, -50.0, kWarning_C, kHot_C, 0.0, 20.0, kLowest_V, kHighest_V};
    for (std::uint8_t sub = 1; sub <= 8; ++sub) {
      if (sub == 5) continue;
      EXPECT_EQ(bench_.write_real(0x2504, sub, static_cast<float>(limits[sub - 1U])), 0U);
    }
    EXPECT_EQ(bench_.write(0x2140, 3, bench_.read(0x2140, 1), 4), 0U);
    bench_.run_ms(2);
    const std::uint32_t acceleration = 15'000'000;
    write(0x6081, 0, static_cast<std::uint32_t>(build_.speed_mps / kResolution_m), 4);
    write(0x6083, 0, acceleration, 4);
    write(0x6084, 0, acceleration, 4);
    write(0x609A, 0, acceleration / 4, 4);
    write(0x60A4, 1, 1'500'000'000, 4);
    write(0x60C2, 1, 2, 1);
    write(0x6099, 1, 100'000, 4);
    write(0x6099, 2, 20'000, 4);
    write(0x605A, 0, build_.quick_stop_option, 2);
    write(0x605B, 0, build_.shutdown_option, 2);
    write(0x605C, 0, build_.disable_option, 2);
    write(0x605D, 0, build_.halt_option, 2);
    write(0x605E, 0, build_.fault_option, 2);
    write(0x2408, 1, build_.brake_release_ms, 2);
    write(0x2408, 2, build_.brake ? 40 : 0, 2);
    // 100 ms without the master's heartbeat (node 127) stop the axis; once it has been heard.
    write(0x1016, 1, (127U << 16) | 100U, 4);
    limit_to(kSoftware_m);
    // RPDO 4: controlword and target velocity, with SYNC.
    write(0x1403, 1, 0x80000500U + can::kNode, 4);
    write(0x1403, 2, 1, 1);
    write(0x1603, 1, 0x60400010, 4);
    write(0x1603, 2, 0x60FF0020, 4);
    write(0x1603, 0, 2, 1);
    write(0x1403, 1, 0x500U + can::kNode, 4);
    // What an NMT reset loads.
    write(0x1010, 1, 0x65766173, 4);
  }

  void write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes) {
    EXPECT_EQ(bench_.write(index, sub, value, bytes), 0U) << std::hex << index;
  }

 public:
  /// 607Dh: the same distance from both end stops.
  void limit_to(double inside_m) {
    // From position zero: as delivered, zero of an absolute encoder.
    write(0x607D, 1, static_cast<std::uint32_t>(counts_at(inside_m)), 4);
    write(0x607D, 2, static_cast<std::uint32_t>(counts_at(kLength_m - inside_m)), 4);
  }

 private:
  Build build_;
  host::HostAnalogueInputs analogue_;
  can::Bench bench_{false};
  std::int32_t last_true_ = 0;
  std::int32_t reading_ = 0;
  double low_s_ = 0.0;
};

}  // namespace slipstack::soak
