// SPDX-License-Identifier: Apache-2.0
// What watches the sensors: every bound is a fault just beyond it, after its time, and none just within it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "firmware/control/supervision/fault_monitor.h"
#include "firmware/control/supervision/faults.h"

namespace slipstack {
namespace {

AxisParameters watched() {
  AxisParameters axis;
  axis.velocity_limit_mps = 0.5F;  // 50 counts a tick
  axis.following_error_m = 2.0e-4F;
  axis.over_current_A = 15.0F;
  axis.current_mismatch_A = 2.0F;
  axis.current_mismatch_s = 2.0e-3F;
  axis.stall_current_A = 5.0F;
  axis.stall_s = 0.02F;
  return axis;
}

/// Readings, tick by tick, of an axis that follows its reference and its set-point but for what a test adds.
class Watch {
 public:
  explicit Watch(bool driving = true) : driving_(driving) {
    monitor_.reset(0);
    EXPECT_EQ(tick(), Fault::kNone);  // from here on there is a step to compare with
  }
  Fault tick() {
    counts_ += step;
    TickInputs in;
    in.encoder.counts = counts_;
    in.current.current_A = set_point_A + off_A;
    in.current.valid = measured;
    return monitor_.check(bounds_, in, counts_ + ahead, set_point_A, driving_);
  }
  /// The tick of the first fault, at most `most`; 0 without one.
  int ticks_to(Fault fault, int most) {
    for (int i = 1; i <= most; ++i) {
      const Fault seen = tick();
      if (seen == Fault::kNone) continue;
      EXPECT_EQ(seen, fault);
      return i;
    }
    return 0;
  }

  std::int32_t step = 0;   ///< counts a tick
  std::int32_t ahead = 0;  ///< of the reference, counts
  float set_point_A = 0.0F;
  float off_A = 0.0F;  ///< of the measurement
  bool measured = true;

 private:
  FaultMonitor monitor_;
  FaultMonitor::Bounds bounds_ = FaultMonitor::bounds(watched());
  std::int32_t counts_ = 0;
  bool driving_;
};

// After a reset there is no step to compare the first one with: an axis that moves is no encoder that jumps.
TEST(FaultMonitor, BeginsOnAnAxisThatMoves) {
  const FaultMonitor::Bounds bounds = FaultMonitor::bounds(watched());
  FaultMonitor monitor;
  std::int32_t counts = 0;
  const auto tick = [&](std::int32_t step) {
    TickInputs in;
    in.encoder.counts = counts += step;
    return monitor.check(bounds, in, counts, 0.0F, false);
  };
  for (const std::int32_t step : {50, -50, 0, 50}) {
    monitor.reset(counts);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(tick(step), Fault::kNone) << step << ' ' << i;
  }
  EXPECT_EQ(tick(-50), Fault::kEncoderJump);
}

TEST(FaultMonitor, ACurrentAwayFromItsSetPoint) {
  for (const bool driving : {false, true}) {
    for (const float sign : {-1.0F, 1.0F}) {
      Watch watch(driving);
      watch.off_A = sign * 1.99F;
      EXPECT_EQ(watch.ticks_to(Fault::kNone, 1000), 0);
      watch.off_A = sign * 2.01F;
      EXPECT_EQ(watch.ticks_to(Fault::kCurrentSensor, 1000), 21) << "longer than 2 ms";
      watch.off_A = 0.0F;
      EXPECT_EQ(watch.tick(), Fault::kNone);
      watch.measured = false;
      EXPECT_EQ(watch.ticks_to(Fault::kCurrentSensor, 1000), 21) << "no measurement";
    }
  }
  // What passes in time is none, and nothing is summed up.
  Watch watch;
  for (int i = 0; i < 100; ++i) {
    watch.off_A = i % 21 < 20 ? 3.0F : 0.0F;
    EXPECT_EQ(watch.tick(), Fault::kNone) << i;
  }
}

TEST(FaultMonitor, ACurrentBeyondItsLargest) {
  for (const float sign : {-1.0F, 1.0F}) {
    Watch watch;
    watch.step = 1;
    watch.set_point_A = sign * 14.9F;
    EXPECT_EQ(watch.ticks_to(Fault::kNone, 1000), 0);
    watch.set_point_A = sign * 15.1F;
    EXPECT_EQ(watch.ticks_to(Fault::kOverCurrent, 10), 1) << "at once";
    EXPECT_EQ(watch.ticks_to(Fault::kOverCurrent, 100), 20) << "and where it does not end in 2 ms";
  }
}

TEST(FaultMonitor, AnAxisThatStandsUnderCurrent) {
  for (const float sign : {-1.0F, 1.0F}) {
    Watch watch;
    watch.set_point_A = sign * 4.99F;
    EXPECT_EQ(watch.ticks_to(Fault::kNone, 1000), 0);
    watch.set_point_A = sign * 5.01F;
    EXPECT_EQ(watch.ticks_to(Fault::kStall, 1000), 201) << "longer than 20 ms";
    watch.step = 1;
    EXPECT_EQ(watch.ticks_to(Fault::kNone, 1000), 0) << "it moves";
    Watch off(false);
    off.set_point_A = sign * 5.01F;
    EXPECT_EQ(off.ticks_to(Fault::kNone, 1000), 0) << "not driven";
  }
}

TEST(FaultMonitor, AnAxisAwayFromItsReference) {
  for (const std::int32_t sign : {-1, 1}) {
    Watch watch;
    watch.ahead = sign * 199;
    EXPECT_EQ(watch.ticks_to(Fault::kNone, 100), 0);
    watch.ahead = sign * 201;
    EXPECT_EQ(watch.ticks_to(Fault::kFollowingError, 100), 1);
    Watch off(false);
    off.ahead = sign * 201;
    EXPECT_EQ(off.ticks_to(Fault::kNone, 100), 0) << "not driven";
  }
}

// The velocity may be half as much again as the limit, and two counts; its change in a tick half of the
// limit, and two.
TEST(FaultMonitor, AnEncoderThatIsTooFastOrJumps) {
  for (const std::int32_t sign : {-1, 1}) {
    Watch watch;
    for (watch.step = 0; std::abs(watch.step) < 76; watch.step += sign) EXPECT_EQ(watch.tick(), Fault::kNone);
    watch.step = sign * 76;
    EXPECT_EQ(watch.ticks_to(Fault::kNone, 100), 0);
    watch.step = sign * 78;
    EXPECT_EQ(watch.ticks_to(Fault::kOverspeed, 100), 1);
    EXPECT_EQ(watch.ticks_to(Fault::kNone, 100), 0) << "told once";
    Watch jumps;
    jumps.step = sign * 26;
    EXPECT_EQ(jumps.ticks_to(Fault::kNone, 100), 0);
    jumps.step = sign * (26 + 28);
    EXPECT_EQ(jumps.ticks_to(Fault::kEncoderJump, 100), 1);
    EXPECT_EQ(jumps.ticks_to(Fault::kNone, 100), 0);
    jumps.step = sign * 26;
    EXPECT_EQ(jumps.ticks_to(Fault::kEncoderJump, 100), 1) << "the other way";
  }
}

TEST(FaultRecord, CountsStopAtTheirLargest) {
  FaultRecord record;
  for (int i = 0; i < 70000; ++i) {
    record.note(Fault::kStall);
    ASSERT_EQ(record.count(Fault::kStall), std::min(i + 1, 0xFFFF));
  }
  record.note(Fault::kOverload);
  EXPECT_EQ(record.count(Fault::kOverload), 1);
  EXPECT_EQ(record.latched(), Fault::kStall) << "the first";
  EXPECT_TRUE(record.has(Fault::kStall));
  EXPECT_TRUE(record.has(Fault::kOverload)) << "and the last";
  EXPECT_FALSE(record.has(Fault::kWatchdog));
  record.reset();
  EXPECT_EQ(record.latched(), Fault::kNone);
  EXPECT_EQ(record.count(Fault::kStall), 0xFFFF) << "counts stay";
}

}  // namespace
}  // namespace slipstack
