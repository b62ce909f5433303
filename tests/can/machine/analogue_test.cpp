// SPDX-License-Identifier: Apache-2.0
// Motor temperature and DC link voltage: objects, warning, faults, and how the axis ends.
#include <cmath>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr std::uint32_t kUnsupported = 0x06010000;
constexpr std::uint32_t kNothingToRead = 0x08000024;

/// 100 degC/V from -50 degC on, warning at 80, fault at 100 degC; 20 V/V, 36 to 60 V.
class Analogue : public ::testing::Test {
 protected:
  Analogue() {
    bench_.analogue = &inputs_;
    bench_.power_on();
    bench_.begin();
    EXPECT_EQ(bench_.write_real(0x2504, 1, 100.0F), 0U);
    EXPECT_EQ(bench_.write_real(0x2504, 2, -50.0F), 0U);
    EXPECT_EQ(bench_.write_real(0x2504, 6, 20.0F), 0U);
    EXPECT_EQ(bench_.write_real(0x2504, 7, 36.0F), 0U);
    EXPECT_EQ(bench_.write_real(0x2504, 8, 60.0F), 0U);
    warm_to(25.0F);
    link_to(48.0F);
    bench_.configure();
  }

  void warm_to(float temperature_C) { inputs_.temperature_now = {0.01F * (temperature_C + 50.0F), true}; }
  void link_to(float voltage_V) { inputs_.bus_now = {voltage_V / 20.0F, true}; }
  std::uint32_t error() { return bench_.read(0x603F, 0); }
  std::uint32_t state() { return bench_.read(0x6041, 0) & 0x6F; }
  bool warned() { return (bench_.read(0x6041, 0) & 0x80) != 0; }
  double velocity() const { return bench_.loop->plant.velocity_mps(); }

  // At 0.2 m/s.
  void move() {
    bench_.enable(3);
    ASSERT_EQ(bench_.write(0x60FF, 0, 200000, 4), 0U);
    bench_.run_ms(200);
    ASSERT_NEAR(velocity(), 0.2, 0.01);
  }
  // Until the current is off; the velocity then.
  double until_released() {
    for (int i = 0; i < 10000 && bench_.loop->motor.enabled; ++i) {
      bench_.loop->step();
      if (i % 10 == 9) {
        bench_.now_us += 1000;
        bench_.poll();
      }
    }
    EXPECT_FALSE(bench_.loop->motor.enabled);
    return velocity();
  }
  void reset_fault() {
    EXPECT_EQ(bench_.write(0x6040, 0, 0x00, 2), 0U);
    bench_.run_ms(2);
    EXPECT_EQ(bench_.write(0x6040, 0, 0x80, 2), 0U);
    bench_.run_ms(2);
  }

  host::HostAnalogueInputs inputs_;
  Bench bench_{false};
};

TEST_F(Analogue, ReadsInDegreesAndMillivolts) {
  bench_.run_ms(2);
  EXPECT_NEAR(bench_.read_real(0x2504, 5), 25.0F, 0.01F);
  EXPECT_NEAR(static_cast<double>(bench_.read(0x6079, 0)), 48000.0, 2.0);
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x90, 0x10U) << "voltage enabled, no warning";
}

TEST_F(Analogue, AWarmMotorWarnsAndAHotOneIsBraked) {
  move();
  warm_to(80.5F);
  bench_.run_ms(500);
  EXPECT_TRUE(warned());
  EXPECT_EQ(state(), 0x27U) << "a warning stops nothing";
  warm_to(79.0F);
  bench_.run_ms(2);
  EXPECT_FALSE(warned());
  warm_to(101.0F);
  bench_.run_ms(90);
  EXPECT_EQ(state(), 0x27U) << "0.1 s";
  bench_.run_ms(20);
  EXPECT_EQ(error(), 0x4310U);
  EXPECT_NEAR(until_released(), 0.0, 0.01);
  EXPECT_EQ(bench_.read(0x1001, 0), 0x09U) << "generic and temperature";
  // As long as it is hot, no reset.
  reset_fault();
  EXPECT_EQ(state(), 0x08U);
  EXPECT_EQ(bench_.read(0x2212, static_cast<std::uint8_t>(Fault::kOverTemperature)), 1U);
  warm_to(99.0F);
  bench_.run_ms(2);
  reset_fault();
  EXPECT_EQ(state(), 0x40U);
  bench_.enable(1);
}

// Braking feeds the link: what can be braked is.
TEST_F(Analogue, ALowLinkBrakesTheAxis) {
  move();
  link_to(35.0F);
  bench_.run_ms(1);
  link_to(48.0F);
  bench_.run_ms(2);
  EXPECT_EQ(state(), 0x27U) << "a dip of 1 ms";
  link_to(35.0F);
  bench_.run_ms(5);
  EXPECT_EQ(error(), 0x3220U);
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x10, 0U) << "voltage enabled";
  EXPECT_GT(velocity(), 0.1);
  EXPECT_NEAR(until_released(), 0.0, 0.01);
  // Not driven, a link without voltage is no fault; driven it is again.
  reset_fault();
  EXPECT_EQ(state(), 0x40U);
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) {
    ASSERT_EQ(bench_.write(0x6040, 0, word, 2), 0U);
    bench_.run_ms(1);
  }
  bench_.run_ms(5);
  EXPECT_EQ(error(), 0x3220U);
  EXPECT_FALSE(bench_.loop->motor.enabled);
  EXPECT_EQ(bench_.read(0x2212, static_cast<std::uint8_t>(Fault::kUnderVoltage)), 2U);
}

// The amplifier has no voltage left to make a force with: the axis does not follow, and is released.
TEST_F(Analogue, ALinkThatBreaksDownReleasesTheAxis) {
  move();
  link_to(5.0F);
  for (int i = 0; i < 20000 && bench_.loop->motor.enabled; ++i) {
    auto& loop = *bench_.loop;
    loop.board_encoder.next.counts = static_cast<std::int32_t>(loop.encoder.counts(loop.plant.position_m()));
    loop.tick.run();
    loop.plant.step(0.0, loop::kTick_s);
    loop.clock.advance(1000);
    if (i % 10 != 9) continue;
    bench_.now_us += 1000;
    bench_.poll();
  }
  EXPECT_EQ(error(), 0x3220U) << "the cause, not what followed";
  EXPECT_FALSE(bench_.loop->motor.enabled);
  EXPECT_GT(velocity(), 0.1) << "it coasts";
}

TEST_F(Analogue, AHighLinkIsReleasedAtOnce) {
  move();
  link_to(61.0F);
  bench_.run_ms(1);
  link_to(59.0F);
  bench_.run_ms(2);
  EXPECT_EQ(state(), 0x27U) << "a peak of 1 ms";
  link_to(61.0F);
  bench_.run_ms(5);
  EXPECT_EQ(error(), 0x3210U);
  EXPECT_FALSE(bench_.loop->motor.enabled) << "braking would feed the link";
  EXPECT_GT(velocity(), 0.1);
  EXPECT_EQ(bench_.read(0x1001, 0), 0x05U) << "generic and voltage";
}

TEST_F(Analogue, AnInputAtItsRailIsASensorFault) {
  move();
  inputs_.temperature_now.valid = false;
  bench_.run_ms(10);
  EXPECT_EQ(state(), 0x27U) << "20 ms";
  bench_.run_ms(15);
  EXPECT_EQ(error(), 0x7300U);
  EXPECT_NEAR(until_released(), 0.0, 0.01);
}

// Bounds are parameters: checked, staged, applied with the axis.
TEST_F(Analogue, RefusesALinkWithoutARange) {
  ASSERT_EQ(bench_.write_real(0x2504, 7, 70.0F), 0U);
  EXPECT_NE(bench_.write(0x2140, 3, bench_.read(0x2140, 1), 4), 0U);
  EXPECT_EQ(bench_.read(0x2140, 4), 1U) << "axis out of bounds";
  bench_.enable(1);
  EXPECT_EQ(bench_.write_real(0x2504, 7, 36.0F), 0x08000022U) << "enabled";
}

// A board says what it has not.
TEST_F(Analogue, OfASignalThatIsNotThereTheGainStaysZero) {
  ASSERT_EQ(bench_.write_real(0x2504, 1, 0.0F), 0U);
  ASSERT_EQ(bench_.write(0x2140, 3, bench_.read(0x2140, 1), 4), 0U);
  bench_.run_ms(2);
  inputs_.temperature_wired = false;
  inputs_.temperature_now.valid = false;
  EXPECT_EQ(bench_.write_real(0x2504, 1, 100.0F), kUnsupported);
  EXPECT_EQ(Bench::number(bench_.sdo(Bench::address(0x40, 0x2504, 5)), 4), kNothingToRead);
  bench_.run_ms(100);
  EXPECT_EQ(error(), 0U);
  Bench without;
  EXPECT_EQ(without.write_real(0x2504, 1, 100.0F), kUnsupported);
  EXPECT_EQ(without.write_real(0x2504, 6, 20.0F), kUnsupported);
  EXPECT_EQ(without.write_real(0x2504, 6, 0.0F), 0U);
  EXPECT_EQ(Bench::number(without.sdo(Bench::address(0x40, 0x6079, 0)), 4), kNothingToRead);
}

// Without limits nothing is one.
TEST_F(Analogue, AsDeliveredNothingIsWired) {
  Bench bench{false};
  host::HostAnalogueInputs inputs;
  inputs.temperature_now = {3.3F, false};
  inputs.bus_now = {0.0F, false};
  bench.analogue = &inputs;
  bench.power_on();
  bench.begin();
  bench.configure();
  bench.enable(1);
  bench.run_ms(200);
  EXPECT_EQ(bench.read(0x603F, 0), 0U);
}

}  // namespace
}  // namespace slipstack::can
