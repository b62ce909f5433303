// SPDX-License-Identifier: Apache-2.0
// Into cyclic synchronous position and out of it: never a step of the reference.
#include "tests/bench/cyclic_position/cyclic_axis.h"
#include "tests/bench/cyclic_position/unsteady_master.h"

namespace slipstack::bench {
namespace {

constexpr double kPeriod_s = 2e-3;

class Entering : public ::testing::Test {
 protected:
  Entering() : axis_(2) {}

  UnsteadyMaster master(std::function<std::int32_t(double)> target) {
    return UnsteadyMaster(axis_.drive().master, can::kNode, kPeriod_s, kPerfect, std::move(target));
  }
  void run_ms(UnsteadyMaster& master, int milliseconds) {
    for (int i = 0; i < 10 * milliseconds; ++i) {
      master.run_until(axis_.time_s() - begun_s_);
      axis_.tick();
    }
  }
  void begin() { begun_s_ = axis_.time_s(); }
  // Profile position towards 150 mm, until it moves at 0.3 m/s.
  void move() {
    can::Bench& drive = axis_.drive();
    drive.write(0x6081, 0, static_cast<std::uint32_t>(0.3 / axis_.resolution_m()), 4);
    drive.write(0x6083, 0, static_cast<std::uint32_t>(5.0 / axis_.resolution_m()), 4);
    drive.write(0x60A4, 1, static_cast<std::uint32_t>(200.0 / axis_.resolution_m()), 4);
    drive.write(0x607A, 0, static_cast<std::uint32_t>(axis_.home() + counts(0.15)), 4);
    drive.write(0x6040, 0, 0x1F, 2);
    axis_.run_ms(200);
    drive.write(0x6040, 0, 0x0F, 2);
  }
  // Cyclic position under way for 600 ms: 0.1 m (1 - cos 2 t), 0.2 m/s at the most.
  UnsteadyMaster swing() {
    axis_.drive().enable(8);
    axis_.drive().nmt(0x01);
    UnsteadyMaster bus = master([this](double time_s) { return axis_.home() + counts(swing_m(time_s)); });
    begin();
    axis_.mark();
    run_ms(bus, 600);
    return bus;
  }
  static double swing_m(double time_s) { return 0.1 * (1.0 - std::cos(2.0 * time_s)); }
  std::int32_t counts(double metres) {
    return static_cast<std::int32_t>(std::lround(metres / axis_.resolution_m()));
  }
  void expect_no_step() {
    EXPECT_EQ(axis_.fault(), Fault::kNone);
    EXPECT_LE(axis_.seen.velocity_mps, 1.001 * static_cast<double>(axis_.axis().velocity_limit_mps));
    // A stop has a deceleration of its own.
    const float largest = std::max(axis_.axis().acceleration_limit_mps2, axis_.axis().quick_stop_mps2);
    EXPECT_LE(axis_.seen.acceleration_mps2, 1.001 * static_cast<double>(largest) + 0.01);
    EXPECT_LT(axis_.seen.error_m, 2e-4);
  }

  // What rounding to counts makes of it in 2 ms, and the correction of the clock's rate, beside the limit.
  void expect_jerk_within() {
    const double rounding = 6.0 * axis_.resolution_m() / std::pow(kPeriod_s, 3);
    EXPECT_LE(axis_.seen.jerk_mps3, static_cast<double>(axis_.axis().jerk_limit_mps3) * 1.05 + rounding);
  }

  CyclicAxis axis_;
  double begun_s_ = 0.0;
};

// SYNC runs, nobody has said where to: whatever 607Ah is, the axis stays.
TEST_F(Entering, WithoutASetPointTheAxisStays) {
  for (const bool stale : {false, true}) {
    axis_.drive().enable(1);
    axis_.drive().nmt(0x01);
    if (stale) axis_.drive().write(0x607A, 0, static_cast<std::uint32_t>(axis_.home() - counts(0.01)), 4);
    axis_.mark();
    UnsteadyMaster bus = master([](double) { return 0; });
    bus.sends_set_points = false;
    begin();
    run_ms(bus, 50);
    const std::int32_t actual = axis_.drive().read_signed(0x6064, 0);
    axis_.drive().write(0x6060, 0, 8, 1);
    run_ms(bus, 500);
    EXPECT_EQ(axis_.drive().read_signed(0x607A, 0), actual);
    EXPECT_LT(std::abs(axis_.reference_m()), 3e-6);
    expect_no_step();
    axis_.drive().write(0x6040, 0, 0x06, 2);
    axis_.run_ms(5);
  }
}

TEST_F(Entering, EnabledInCyclicPositionItStartsAtThePositionActualValue) {
  axis_.drive().nmt(0x01);
  axis_.drive().write(0x607A, 0, 0, 4);
  UnsteadyMaster bus = master([](double) { return 0; });
  bus.sends_set_points = false;
  begin();
  run_ms(bus, 50);
  axis_.drive().enable(8);
  axis_.mark();
  EXPECT_NEAR(axis_.drive().read_signed(0x607A, 0), axis_.home(), 5);
  run_ms(bus, 300);
  EXPECT_LT(axis_.seen.velocity_mps, 1e-3);
  expect_no_step();
}

// From profile position at 0.3 m/s; the master streams the place where the axis was.
TEST_F(Entering, FromAMoveThatIsUnderWay) {
  axis_.drive().enable(1);
  axis_.drive().nmt(0x01);
  move();
  const std::int32_t there = axis_.drive().read_signed(0x6064, 0);
  UnsteadyMaster bus = master([&](double time_s) { return there + counts(0.02 * time_s); });
  begin();
  axis_.drive().write(0x6060, 0, 8, 1);
  axis_.mark();
  run_ms(bus, 1500);
  expect_no_step();
  // It has come back to the stream, three periods late.
  EXPECT_NEAR(axis_.reference_m(),
              (there - axis_.home()) * axis_.resolution_m() + 0.02 * (1.5 - 3 * kPeriod_s), 2e-5);
}

// The stream goes on while the axis is halted, and halt is released before the axis has come to rest.
TEST_F(Entering, HaltReleasedWhileBraking) {
  UnsteadyMaster bus = swing();
  for (int i = 0; i < 4; ++i) {
    bus.controlword = 0x0F;
    bus.controlword = 0x0F;
    bus.sends_set_points = false;
    axis_.drive().write(0x6040, 0, 0x010F, 2);
    run_ms(bus, 3 + 5 * i);
    axis_.drive().write(0x6040, 0, 0x000F, 2);
    bus.sends_set_points = true;
    run_ms(bus, 400);
  }
  expect_no_step();
  EXPECT_NEAR(axis_.reference_m(), swing_m(axis_.time_s() - begun_s_ - 3 * kPeriod_s), 2e-5);
}

// The cable is out for 100 ms at 0.2 m/s: the axis stops, stays, and goes on with the stream.
// Longer than the command time-out as delivered, which would end with a quick stop
// (tests/can/connection_supervision/command_timeout_test.cpp).
TEST_F(Entering, ALongGapIsAStopAndTheStreamIsMetAgain) {
  EXPECT_EQ(axis_.drive().write(0x2403, 0, 0, 2), 0U);
  UnsteadyMaster bus = swing();
  bus.sends_sync = bus.sends_set_points = false;
  run_ms(bus, 100);
  EXPECT_TRUE(axis_.controller().reference().standing());
  const double stands_m = axis_.reference_m();
  run_ms(bus, 5);
  EXPECT_EQ(axis_.reference_m(), stands_m);
  bus.sends_sync = bus.sends_set_points = true;
  run_ms(bus, 800);
  expect_no_step();
  EXPECT_NEAR(axis_.reference_m(), swing_m(axis_.time_s() - begun_s_ - 3 * kPeriod_s), 2e-5);
}

// A target far away, written once: with the velocity, acceleration and jerk of the axis, no more; and as fast
// as they allow. 0.1 m take v / a + a / j + x / v = 0.418 s.
TEST_F(Entering, ASetPointFarAwayIsReachedWithinTheLimits) {
  axis_.drive().enable(8);
  axis_.drive().nmt(0x01);
  UnsteadyMaster bus = master([&](double time_s) { return axis_.home() + (time_s > 0.1 ? counts(0.1) : 0); });
  begin();
  axis_.mark();
  run_ms(bus, 100 + 418 + 30);
  expect_no_step();
  expect_jerk_within();
  EXPECT_NEAR(axis_.reference_m(), 0.1, 1e-6);
  EXPECT_GT(axis_.seen.velocity_mps, 0.29);
}

// Set-points of a stream in motion leap, to and fro, near and far: by its jerk limit too.
TEST_F(Entering, LeapsOfARunningStreamMeetTheJerkLimit) {
  axis_.drive().enable(8);
  axis_.drive().nmt(0x01);
  double leap_m = 0.0;
  UnsteadyMaster bus = master([&](double time_s) { return axis_.home() + counts(swing_m(time_s) + leap_m); });
  begin();
  axis_.mark();
  for (const double to_m : {0.0, 3e-5, 0.0, 2e-3, -2e-3, 0.05, 0.0, -0.08, 0.0}) {
    leap_m = to_m;
    run_ms(bus, 700);
    EXPECT_NEAR(axis_.reference_m(), swing_m(axis_.time_s() - begun_s_ - 3 * kPeriod_s) + leap_m, 2e-5)
        << to_m;
  }
  expect_no_step();
  expect_jerk_within();
}

// A stream that leads out of the range, at full speed: the reference does not pass the end by a count, comes
// to rest there within its limits, and follows again.
TEST_F(Entering, AStreamOutOfTheRangeEndsAtItsEnd) {
  const double end_m = 0.04;
  EXPECT_EQ(axis_.drive().write(0x607D, 2, static_cast<std::uint32_t>(axis_.home() + counts(end_m)), 4), 0U);
  axis_.drive().enable(8);
  axis_.drive().nmt(0x01);
  UnsteadyMaster bus = master([&](double time_s) {
    const double way_m = 0.25 * std::max(0.0, time_s - 0.1) - 0.5 * std::max(0.0, time_s - 0.5);
    return axis_.home() + counts(way_m);
  });
  begin();
  axis_.mark();
  double farthest_m = 0.0;
  for (int i = 0; i < 1000; ++i) {
    run_ms(bus, 1);
    farthest_m = std::max(farthest_m, axis_.reference_m());
  }
  EXPECT_LE(farthest_m, end_m + 1e-9);
  EXPECT_GT(farthest_m, end_m - 2e-6);
  EXPECT_LT(axis_.reference_m(), end_m - 0.02) << "and back with the stream";
  expect_no_step();
  expect_jerk_within();
}

}  // namespace
}  // namespace slipstack::bench
