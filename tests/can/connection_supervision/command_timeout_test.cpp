// SPDX-License-Identifier: Apache-2.0
// A master that falls silent in a cyclic mode: the tick ends the motion, as 6007h says.
#include <cmath>
#include <string>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

constexpr std::uint8_t kProfilePosition = 1;
constexpr std::uint8_t kCyclicPosition = 8;
constexpr std::uint8_t kCyclicTorque = 10;
constexpr int kTimeout_ms = 50;  // default of 2403h

class SilentMaster : public ::testing::Test {
 protected:
  SilentMaster() { bench_.configure(); }

  double velocity() const { return bench_.loop->plant.velocity_mps(); }
  double position_m() const { return bench_.loop->plant.position_m(); }
  bool driving() const { return bench_.loop->motor.enabled; }

  // Half of the rated force pushes the axis to 0.2 m/s; the master repeats its command every 2 ms.
  void push() {
    bench_.enable(kCyclicTorque);
    for (int i = 0; i < 500 && velocity() < 0.2; ++i) {
      ASSERT_EQ(bench_.write(0x6071, 0, 120, 2), 0U);
      bench_.run_ms(2);
    }
    ASSERT_GE(velocity(), 0.2);
    ASSERT_TRUE(driving());
    pushed_to_m_ = position_m();
  }

  // A controller whose main loop stands still; the tick goes on.
  void run_ticks_only(int milliseconds) {
    for (int i = 0; i < 10 * milliseconds; ++i) bench_.loop->step();
  }

  Bench bench_;
  double pushed_to_m_ = 0.0;
};

TEST_F(SilentMaster, InTorqueModeTheAxisStops) {
  push();
  bench_.all();
  bench_.run_ms(kTimeout_ms - 2);
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x6F, 0x27U) << "not before the time";
  bench_.run_ms(200);
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x6F, 0x40U) << "quick stop, then switch on disabled";
  EXPECT_FALSE(driving());
  EXPECT_LT(std::abs(velocity()), 1e-3);
  // 0.2 m/s and 1 m/s2 for 50 ms: 11 mm; then 0.25 m/s to rest within the jerk limit of 200 m/s3, which never
  // reaches 15 m/s2: v sqrt(v / j) = 9 mm.
  EXPECT_LT(position_m() - pushed_to_m_, 0.023);
  EXPECT_GT(position_m() - pushed_to_m_, 0.005);
}

TEST_F(SilentMaster, TheErrorIsReportedUntilCommandsComeAgain) {
  push();
  bench_.nmt(0x01);
  bench_.run_ms(2);
  bench_.all();
  bench_.run_ms(kTimeout_ms + 5);
  const auto lost = bench_.all_with(0x085);
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(Bench::number(lost[0], 0, 2), 0x8100U);
  EXPECT_EQ(lost[0][2], 0x11);
  EXPECT_EQ(bench_.read(0x603F, 0), 0x8100U);
  ASSERT_EQ(bench_.write(0x6071, 0, 0, 2), 0U);
  bench_.run_ms(2);
  EXPECT_EQ(bench_.read(0x603F, 0), 0U);
}

// Only a stream of set-points can fail to come: a drive that is enabled waits for the first one for as long
// as it takes, whatever else is written.
TEST_F(SilentMaster, BeforeTheFirstSetPointNobodyIsMissed) {
  for (const std::uint8_t mode : {kCyclicPosition, kCyclicTorque}) {
    bench_.enable(mode);
    ASSERT_EQ(bench_.write(0x6040, 0, 0x0F, 2), 0U);
    ASSERT_EQ(bench_.write(0x6060, 0, mode, 1), 0U);
    bench_.run_ms(4 * kTimeout_ms);
    EXPECT_EQ(bench_.read(0x6041, 0) & 0x6F, 0x27U) << int{mode};
    EXPECT_EQ(bench_.read(0x603F, 0), 0U) << int{mode};
    ASSERT_EQ(bench_.write(0x6040, 0, 0, 2), 0U);
    bench_.run_ms(5);
  }
}

// A main loop that stands still cannot act: the tick does.
TEST_F(SilentMaster, TheTickStopsTheAxisWithoutTheMainLoop) {
  push();
  run_ticks_only(kTimeout_ms - 2);
  EXPECT_TRUE(driving());
  EXPECT_GT(velocity(), 0.2);
  run_ticks_only(200);
  EXPECT_FALSE(driving());
  EXPECT_LT(std::abs(velocity()), 1e-3);
}

TEST_F(SilentMaster, CommandsThatComeAgainDoNotMoveTheAxisAgain) {
  for (const std::uint32_t quick_stop : {2U, 6U}) {
    ASSERT_EQ(bench_.write(0x605A, 0, quick_stop, 2), 0U);
    push();
    bench_.run_ms(kTimeout_ms + 150);
    for (int i = 0; i < 20; ++i) {
      ASSERT_EQ(bench_.write(0x6071, 0, 120, 2), 0U);
      bench_.run_ms(2);
    }
    EXPECT_NE(bench_.read(0x6041, 0) & 0x6F, 0x27U) << quick_stop;
    EXPECT_LT(std::abs(velocity()), 1e-3) << quick_stop;
    ASSERT_EQ(bench_.write(0x6040, 0, 0, 2), 0U);
    ASSERT_EQ(bench_.write(0x6071, 0, 0, 2), 0U);
    bench_.run_ms(5);
  }
}

TEST_F(SilentMaster, TheReactionFollowsTheOption) {
  for (const std::uint32_t reaction : {0U, 2U, 3U}) {
    ASSERT_EQ(bench_.write(0x6007, 0, reaction, 2), 0U);
    push();
    bench_.run_ms(kTimeout_ms + 2);
    EXPECT_EQ(driving(), reaction != 2) << reaction;
    bench_.run_ms(60);
    const bool moves = std::abs(velocity()) > 0.1;
    EXPECT_EQ(moves, reaction != 3) << reaction << ": pushed on, coasting, or braked; " << velocity();
    ASSERT_EQ(bench_.write(0x6040, 0, 0, 2), 0U);
    ASSERT_EQ(bench_.write(0x6071, 0, 0, 2), 0U);
    bench_.run_ms(2000);
    ASSERT_LT(std::abs(velocity()), 1e-3);
  }
}

// 6007h = 1, fault signal: braked as a fault is, and it stays one until it is reset.
TEST_F(SilentMaster, ALossThatIsToBeAFaultIsOne) {
  for (const std::uint32_t reaction : {2U, 0U}) {
    ASSERT_EQ(bench_.write(0x6007, 0, 1, 2), 0U);
    ASSERT_EQ(bench_.write(0x605E, 0, reaction, 2), 0U);
    push();
    bench_.run_ms(kTimeout_ms + 5);
    EXPECT_EQ(bench_.read(0x6041, 0) & 0x4F, reaction == 2 ? 0x0FU : 0x08U) << "fault reaction, or fault";
    bench_.run_ms(200);
    EXPECT_EQ(bench_.read(0x6041, 0) & 0x4F, 0x08U);
    EXPECT_FALSE(driving());
    EXPECT_EQ(std::abs(velocity()) < 1e-3, reaction == 2) << "braked, or released";
    ASSERT_EQ(bench_.write(0x6071, 0, 0, 2), 0U);
    bench_.run_ms(10);
    EXPECT_EQ(bench_.read(0x603F, 0), 0x8100U) << "commands that come again do not end it";
    EXPECT_GE(bench_.read(0x2212, static_cast<std::uint8_t>(Fault::kConnection)), 1U);
    bench_.run_ms(2000);
    ASSERT_EQ(bench_.write(0x6040, 0, 0x80, 2), 0U);
    bench_.run_ms(5);
    EXPECT_EQ(bench_.read(0x603F, 0), 0U);
    EXPECT_EQ(bench_.read(0x6041, 0) & 0x4F, 0x40U);
    ASSERT_EQ(bench_.write(0x6040, 0, 0, 2), 0U);
  }
}

// The same where the main loop is held up until the tick's own stop is over: a fault all the same, told once,
// counted once, and gone for good when it is reset, whether a poll or a command sees the loss first.
TEST_F(SilentMaster, ALossThatTheMainLoopSeesAfterTheStopIsAFault) {
  for (const bool command_first : {false, true}) {
    SCOPED_TRACE(command_first ? "a command sees it first" : "a poll sees it first");
    Bench bench;
    bench.configure();
    ASSERT_EQ(bench.write(0x6007, 0, 1, 2), 0U);
    bench.nmt(0x01);
    bench.enable(kCyclicTorque);
    ASSERT_EQ(bench.write(0x6071, 0, 5, 2), 0U);
    bench.all();
    for (int i = 0; i < 10 * (kTimeout_ms + 200); ++i) bench.loop->step();
    ASSERT_FALSE(bench.loop->motor.enabled) << "the stop is over";
    if (command_first) bench.send(0x605, {0x2B, 0x71, 0x60, 0, 0, 0, 0, 0});
    bench.poll();
    bench.run_ms(50);
    const auto told = bench.all_with(0x085);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(Bench::number(told[0], 0, 2), 0x8100U);
    EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x08U) << "latched";
    EXPECT_EQ(bench.read(0x603F, 0), 0x8100U);
    EXPECT_EQ(bench.read(0x2212, static_cast<std::uint8_t>(Fault::kConnection)), 1U);
    // The first command after the loss.
    ASSERT_EQ(bench.write(0x6040, 0, 0x80, 2), 0U);
    bench.run_ms(500);
    EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x40U) << "the reset holds";
    EXPECT_EQ(bench.read(0x603F, 0), 0U);
    EXPECT_EQ(bench.read(0x2212, static_cast<std::uint8_t>(Fault::kConnection)), 1U);
    // The next loss is one of its own.
    bench.enable(kCyclicTorque);
    ASSERT_EQ(bench.write(0x6071, 0, 5, 2), 0U);
    for (int i = 0; i < 10 * (kTimeout_ms + 200); ++i) bench.loop->step();
    bench.run_ms(5);
    EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x08U);
    EXPECT_EQ(bench.read(0x2212, static_cast<std::uint8_t>(Fault::kConnection)), 2U);
  }
}

TEST_F(SilentMaster, TheTimeIsAParameterAndZeroSwitchesItOff) {
  ASSERT_EQ(bench_.read(0x2403, 0), static_cast<std::uint32_t>(kTimeout_ms));
  for (const int timeout_ms : {10, 0}) {
    ASSERT_EQ(bench_.write(0x2403, 0, static_cast<std::uint32_t>(timeout_ms), 2), 0U);
    bench_.enable(kCyclicTorque);
    EXPECT_EQ(bench_.write(0x2403, 0, 1, 2), 0x08000022U) << "a parameter: not while enabled";
    ASSERT_EQ(bench_.write(0x6071, 0, 5, 2), 0U);
    bench_.run_ms(9);
    EXPECT_TRUE(driving());
    bench_.run_ms(100);
    EXPECT_EQ(driving(), timeout_ms == 0);
    ASSERT_EQ(bench_.write(0x6040, 0, 0, 2), 0U);
    bench_.run_ms(2);
  }
}

// A force that was given before the axis was enabled acts at once, so the time begins at once.
TEST_F(SilentMaster, AForceFromBeforeIsWatchedToo) {
  ASSERT_EQ(bench_.write(0x6071, 0, 120, 2), 0U);
  bench_.enable(kCyclicTorque);
  bench_.run_ms(kTimeout_ms + 150);
  EXPECT_FALSE(driving());
  EXPECT_LT(std::abs(velocity()), 1e-3);
}

TEST_F(SilentMaster, InCyclicPositionTheAxisStops) {
  bench_.nmt(0x01);
  ASSERT_EQ(bench_.write(0x60C2, 1, 2, 1), 0U);
  bench_.enable(kCyclicPosition);
  const std::int32_t home = bench_.read_signed(0x6064, 0);
  bench_.run_ms(500);
  EXPECT_TRUE(driving()) << "enabled, and nothing commanded yet: nothing to lose";
  for (int i = 0; i < 200; ++i) {
    const auto target = static_cast<std::uint32_t>(home + 4 * i);
    bench_.send(0x305, {0x0F, 0x00, static_cast<std::uint8_t>(target), static_cast<std::uint8_t>(target >> 8),
                        static_cast<std::uint8_t>(target >> 16), static_cast<std::uint8_t>(target >> 24)});
    bench_.send(0x080, {});
    bench_.run_ms(2);
    ASSERT_TRUE(driving()) << i;
  }
  // SYNC alone, of another node, is no command.
  for (int i = 0; i < 100; ++i) {
    bench_.send(0x080, {});
    bench_.run_ms(2);
  }
  EXPECT_FALSE(driving());
  EXPECT_EQ(bench_.read(0x6041, 0) & 0x4F, 0x40U);
}

// By SDO, without a controlword beside it: the velocity that was written is a set-point to be repeated, also
// that of an axis which stands.
TEST_F(SilentMaster, InCyclicVelocityTheAxisStops) {
  for (const std::uint32_t wanted : {20000U, 0U}) {
    Bench bench;
    bench.configure();
    bench.nmt(0x01);
    ASSERT_EQ(bench.write(0x60C2, 1, 2, 1), 0U);
    bench.enable(9);
    bench.run_ms(500);
    EXPECT_TRUE(bench.loop->motor.enabled) << "nothing commanded yet";
    for (int i = 0; i < 200; ++i) {
      ASSERT_EQ(bench.write(0x60FF, 0, wanted, 4), 0U);
      bench.send(0x080, {});
      bench.run_ms(2);
      ASSERT_TRUE(bench.loop->motor.enabled) << i;
    }
    EXPECT_NEAR(bench.loop->plant.velocity_mps(), 1e-6 * wanted, 0.002);
    for (int i = 0; i < 100; ++i) {
      bench.send(0x080, {});
      bench.run_ms(2);
    }
    EXPECT_FALSE(bench.loop->motor.enabled) << wanted;
    EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x40U);
  }
}

// The tick has seen the loss, and the next thing that the main loop sees is a command: the loss counts, and
// where it is to be a fault it is one.
TEST_F(SilentMaster, ACommandThatComesTooLateDoesNotUndoTheLoss) {
  for (const std::uint32_t reaction : {1U, 2U, 3U}) {
    for (const int late_ms : {-5, 5}) {
      SCOPED_TRACE(std::to_string(reaction) + (late_ms > 0 ? " late" : " in time"));
      Bench bench;
      bench.configure();
      ASSERT_EQ(bench.write(0x6007, 0, reaction, 2), 0U);
      bench.enable(kCyclicTorque);
      ASSERT_EQ(bench.write(0x6071, 0, 120, 2), 0U);
      // Pushed, so that the stop is not over when the main loop looks.
      for (int i = 0; i < 10 * (kTimeout_ms + late_ms); ++i) bench.loop->step();
      ASSERT_EQ(bench.write(0x6071, 0, 120, 2), 0U);
      for (int i = 0; i < 10; ++i) {
        bench.run_ms(5);
        ASSERT_EQ(bench.write(0x6071, 0, 120, 2), 0U);
      }
      EXPECT_EQ((bench.read(0x6041, 0) & 0x6F) == 0x27U, late_ms < 0);
      const bool is_fault = reaction == 1 && late_ms > 0;
      EXPECT_EQ(bench.read(0x603F, 0), is_fault ? 0x8100U : 0U);
      EXPECT_EQ(bench.read(0x2212, static_cast<std::uint8_t>(Fault::kConnection)), is_fault ? 1U : 0U);
    }
  }
}

// A move of profile position is complete when it is commanded.
TEST_F(SilentMaster, AProfileMoveRunsToItsEnd) {
  bench_.enable(kProfilePosition);
  const std::int32_t target = bench_.read_signed(0x6064, 0) + 50000;
  ASSERT_EQ(bench_.write(0x607A, 0, static_cast<std::uint32_t>(target), 4), 0U);
  ASSERT_EQ(bench_.write(0x6040, 0, 0x1F, 2), 0U);
  bench_.run_ms(3000);
  EXPECT_TRUE(driving());
  EXPECT_NEAR(bench_.read_signed(0x6064, 0), target, 5);
}

// 1400h:05 has the reaction of a lost connection, whatever the mode: the master asked to be watched.
TEST_F(SilentMaster, AnRpdoThatFailsToComeIsALostConnection) {
  bench_.nmt(0x01);
  ASSERT_EQ(bench_.write(0x1400, 5, 30, 2), 0U);
  bench_.enable(kProfilePosition);
  ASSERT_EQ(bench_.write(0x607A, 0, static_cast<std::uint32_t>(bench_.read_signed(0x6064, 0) + 100000), 4),
            0U);
  bench_.send(0x205, {0x1F, 0x00, 0x01});
  bench_.run_ms(28);
  EXPECT_TRUE(driving());
  bench_.run_ms(250);
  EXPECT_FALSE(driving());
  EXPECT_LT(std::abs(velocity()), 1e-3);
}

// Each object that commands the axis is a sign of life, and no other.
TEST_F(SilentMaster, EveryCommandIsASignOfLife) {
  struct Command {
    std::uint16_t index;
    int bytes;
    std::uint32_t value;
    bool counts;
  };
  for (const Command& command : {
           Command{0x6040, 2, 0x0F, true},
           {0x6060, 1, kCyclicTorque, true},
           {0x607A, 4, 0, true},
           {0x6071, 2, 0, true},
           {0x60B0, 4, 0, true},
           {0x60B1, 4, 0, true},
           {0x60B2, 2, 0, true},
           {0x60FF, 4, 0, true},
           {0x6081, 4, 1000, false},
           {0x6083, 4, 100000, false},
       }) {
    Bench bench;
    bench.configure();
    bench.enable(kCyclicTorque);
    ASSERT_EQ(bench.write(0x6071, 0, 0, 2), 0U);
    for (int i = 0; i < 5; ++i) {
      bench.run_ms(kTimeout_ms - 10);
      ASSERT_EQ(bench.write(command.index, 0, command.value, command.bytes), 0U) << std::hex << command.index;
    }
    const bool enabled = (bench.read(0x6041, 0) & 0x6F) == 0x27U;
    EXPECT_EQ(enabled, command.counts) << std::hex << command.index;
  }
}

}  // namespace
}  // namespace slipstack::can
