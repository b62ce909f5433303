// SPDX-License-Identifier: Apache-2.0
// The drive profile on the simulated axis: state machine, three modes, faults, locked parameters.
#include <algorithm>
#include <cmath>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

/// Profile position under way at this profile velocity, counts/s, towards `distance` from where the axis is,
/// which is returned.
std::int32_t begin_move(Bench& bench, std::uint32_t velocity, std::int32_t distance) {
  bench.configure();
  bench.enable(1);
  const std::int32_t home = bench.read_signed(0x6064, 0);
  EXPECT_EQ(bench.write(0x6081, 0, velocity, 4), 0U);
  EXPECT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(home + distance), 4), 0U);
  EXPECT_EQ(bench.write(0x6040, 0, 0x1F, 2), 0U);
  return home;
}

TEST(Drive, StatusWordOfEachState) {
  Bench bench;
  EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x00U) << "not ready: no model";
  bench.configure();
  EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x40U);
  const auto after = [&](std::uint32_t word) {
    bench.write(0x6040, 0, word, 2);
    bench.run_ms(1);
    return bench.read(0x6041, 0) & 0x6F;
  };
  EXPECT_EQ(after(0x06), 0x21U);
  EXPECT_EQ(after(0x07), 0x23U);
  EXPECT_EQ(after(0x0F), 0x27U);
  EXPECT_EQ(after(0x07), 0x23U);
  EXPECT_EQ(after(0x0F), 0x27U);
  EXPECT_EQ(after(0x06), 0x21U);
  EXPECT_EQ(after(0x00) & 0x4F, 0x40U);
  EXPECT_EQ(bench.read(0x6502, 0), 0x3A5U) << "pp, pv, hm, csp, csv, cst";
}

TEST(Drive, ProfilePositionHandshakeAndArrival) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  const std::int32_t home = bench.read_signed(0x6064, 0);
  ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(home + 20000), 4), 0U);
  bench.run_ms(20);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x1400, 0x0400U);
  ASSERT_EQ(bench.write(0x6040, 0, 0x1F, 2), 0U);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x1400, 0x1000U) << "set-point acknowledged";
  bench.run_ms(20);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x0400, 0U) << "under way";
  ASSERT_EQ(bench.write(0x6040, 0, 0x0F, 2), 0U);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x1000, 0U);
  // 20 mm at 0.1 m/s (profile velocity, slower than the axis may), some ramps: between 0.2 and 0.35 s.
  bench.run_ms(150);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x0400, 0U);
  EXPECT_NEAR(bench.read_signed(0x606C, 0), 100000, 3000);
  bench.run_ms(200);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x0400, 0x0400U);
  EXPECT_NEAR(bench.read_signed(0x6064, 0), home + 20000, 10);
  // Relative, and halt.
  ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(-50000), 4), 0U);
  ASSERT_EQ(bench.write(0x6040, 0, 0x5F, 2), 0U);
  bench.run_ms(200);
  ASSERT_EQ(bench.write(0x6040, 0, 0x10F, 2), 0U);
  bench.run_ms(200);
  const std::int32_t halted = bench.read_signed(0x6064, 0);
  EXPECT_LT(halted, home + 15000);
  EXPECT_GT(halted, home - 20000);
  bench.run_ms(100);
  EXPECT_NEAR(bench.read_signed(0x6064, 0), halted, 10);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x46F, 0x427U) << "halted: at rest";
  // Released: the move goes on.
  ASSERT_EQ(bench.write(0x6040, 0, 0x0F, 2), 0U);
  bench.run_ms(50);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x0400, 0U);
  bench.run_ms(700);
  EXPECT_NEAR(bench.read_signed(0x6064, 0), home - 30000, 10);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x0400, 0x0400U);
}

// Of any duration: 200 mm at 1 mm/s is under way for 200 s, and says so.
TEST(Drive, ASlowMoveIsUnderWayUntilItArrives) {
  Bench bench;
  const std::int32_t home = begin_move(bench, 1000, 200000);
  bench.run_ms(3000);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x0400, 0U);
  EXPECT_EQ(bench.read(0x603F, 0), 0U);
  EXPECT_NEAR(bench.read_signed(0x6064, 0), home + 3000, 50);
}

// What no trajectory can be computed for is a fault, and no arrival.
TEST(Drive, ARefusedSetPointIsAFault) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  bench.run_ms(20);
  const auto go = [&](std::uint32_t target, std::uint32_t control) {
    ASSERT_EQ(bench.write(0x607A, 0, target, 4), 0U);
    ASSERT_EQ(bench.write(0x6040, 0, control, 2), 0U);
    bench.run_ms(2);
    ASSERT_EQ(bench.write(0x6040, 0, 0x0F, 2), 0U);
  };
  ASSERT_EQ(bench.write(0x6083, 0, 1, 4), 0U);
  ASSERT_EQ(bench.write(0x6084, 0, 1, 4), 0U);
  ASSERT_EQ(bench.write(0x60A4, 1, 1, 4), 0U);
  go(0x7FFFFFFF, 0x1F);  // ramps of years
  EXPECT_EQ(bench.read(0x603F, 0), 0x8600U);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x08U);
  EXPECT_EQ(bench.read(0x2212, 12), 1U);
}

// Retargeted in motion: a new set-point at once does not stop the axis first.
TEST(Drive, ASetPointAtOnceGoesOnFromTheMotion) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  const std::int32_t home = bench.read_signed(0x6064, 0);
  const auto go = [&](std::int32_t target) {
    ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(target), 4), 0U);
    ASSERT_EQ(bench.write(0x6040, 0, 0x3F, 2), 0U);
    ASSERT_EQ(bench.write(0x6040, 0, 0x2F, 2), 0U);
  };
  go(home + 20000);
  bench.run_ms(150);
  go(home + 40000);
  for (int ms = 0; ms < 100; ++ms) {
    bench.run_ms(1);
    ASSERT_NEAR(bench.read_signed(0x606C, 0), 100000, 4000) << ms;
  }
  go(home);  // and turns round
  bench.run_ms(800);
  EXPECT_NEAR(bench.read_signed(0x6064, 0), home, 10);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x0400, 0x0400U);
}

// The window: bit 10 falls when the axis is pushed out of it.
TEST(Drive, TargetReachedMeansTheAxisIsInItsWindow) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  bench.run_ms(20);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x0400, 0x0400U);
  ASSERT_EQ(bench.write(0x6067, 0, 0, 4), 0U);
  ASSERT_EQ(bench.write(0x6068, 0, 50, 2), 0U);
  ASSERT_EQ(bench.write(0x60B2, 0, 200, 2), 0U);
  int outside = 0;
  for (int ms = 0; ms < 30; ++ms) {
    bench.run_ms(1);
    outside += (bench.read(0x6041, 0) & 0x0400) == 0 ? 1 : 0;
  }
  EXPECT_GT(outside, 10);
}

// 6068h: it counts as reached when it has been in the window for so long, each time anew, however long the
// drive has been on.
TEST(Drive, TargetReachedComesAfterTheTimeInTheWindow) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  ASSERT_EQ(bench.write(0x6067, 0, 50, 4), 0U);
  ASSERT_EQ(bench.write(0x6068, 0, 100, 2), 0U);
  for (int move = 0; move < 3; ++move) {
    const auto target = static_cast<std::uint32_t>(bench.read_signed(0x6064, 0) + 3000);
    ASSERT_EQ(bench.write(0x607A, 0, target, 4), 0U);
    ASSERT_EQ(bench.write(0x6040, 0, 0x3F, 2), 0U);
    const ReferenceGenerator& reference = bench.loop->controller().reference();
    int arrived = -1, reached = -1;
    for (int ms = 0; ms < 2000 && reached < 0; ++ms) {
      bench.run_ms(1);
      if (arrived < 0 && ms > 10 && reference.idle()) arrived = ms;
      if ((bench.read(0x6041, 0) & 0x0400) != 0) reached = ms;
    }
    EXPECT_GE(reached - arrived, 98) << move;
    EXPECT_LE(reached - arrived, 130) << move << ": the axis is there soon after the reference";
    ASSERT_EQ(bench.write(0x6040, 0, 0x0F, 2), 0U);
    bench.run_ms(200);
  }
}

// A master sends controlword and target in one frame, and may map them in either order.
TEST(Drive, ASetPointIsTheTargetThatCameInTheSameFrame) {
  for (const bool target_first : {false, true}) {
    for (const std::uint32_t type : {1U, 255U}) {
      Bench bench;
      bench.configure();
      ASSERT_EQ(bench.write(0x1401, 1, 0x80000305, 4), 0U);
      ASSERT_EQ(bench.write(0x1401, 2, type, 1), 0U);
      ASSERT_EQ(bench.write(0x1601, 0, 0, 1), 0U);
      ASSERT_EQ(bench.write(0x1601, 1, target_first ? 0x607A0020 : 0x60400010, 4), 0U);
      ASSERT_EQ(bench.write(0x1601, 2, target_first ? 0x60400010 : 0x607A0020, 4), 0U);
      ASSERT_EQ(bench.write(0x1601, 0, 2, 1), 0U);
      ASSERT_EQ(bench.write(0x1401, 1, 0x305, 4), 0U);
      bench.enable(1);
      bench.nmt(0x01);
      const std::int32_t home = bench.read_signed(0x6064, 0);
      for (const int way : {3000, -2000}) {
        const auto target = static_cast<std::uint32_t>(home + way);
        for (const std::uint8_t word : {std::uint8_t{0x0F}, std::uint8_t{0x1F}}) {
          // The word that asks for nothing carries another target: what counts came with the one that asks.
          const std::uint32_t carried = word == 0x1F ? target : static_cast<std::uint32_t>(home + 50000);
          Data data = {word, 0};
          for (int i = 0; i < 4; ++i) data.push_back(static_cast<std::uint8_t>(carried >> (8 * i)));
          if (target_first) std::rotate(data.begin(), data.begin() + 2, data.end());
          bench.send(0x305, data);
          if (type == 1) bench.send(0x080, {});
          bench.run_ms(1);
        }
        bench.run_ms(400);
        EXPECT_NEAR(bench.read_signed(0x6064, 0), home + way, 10) << target_first << ' ' << type;
      }
    }
  }
}

// Profile velocity and the others belong to the set-point: they may be changed while the drive is enabled,
// and a move under way keeps its own.
TEST(Drive, TheProfileIsThatOfTheSetPoint) {
  Bench bench;
  const std::int32_t home = begin_move(bench, 50000, 20000);
  bench.run_ms(10);
  ASSERT_EQ(bench.write(0x6040, 0, 0x0F, 2), 0U);
  // The next, back again, waits until this one is done; its velocity is taken with it.
  ASSERT_EQ(bench.write(0x6081, 0, 20000, 4), 0U);
  ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(home), 4), 0U);
  ASSERT_EQ(bench.write(0x6040, 0, 0x1F, 2), 0U);
  ASSERT_EQ(bench.write(0x6081, 0, 90000, 4), 0U);
  bench.run_ms(200);
  EXPECT_NEAR(bench.read_signed(0x606C, 0), 50000, 2500);
  bench.run_ms(500);
  EXPECT_NEAR(bench.read_signed(0x606C, 0), -20000, 1500);
  bench.run_ms(1000);
  EXPECT_NEAR(bench.read_signed(0x6064, 0), home, 10);
}

TEST(Drive, ARelativeTargetCountsFromTheTargetBeforeOrFromWhereTheAxisIsAsked) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  const std::int32_t home = bench.read_signed(0x6064, 0);
  const auto go = [&](int way) {
    ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(way), 4), 0U);
    ASSERT_EQ(bench.write(0x6040, 0, 0x5F, 2), 0U);
    bench.run_ms(1);
    ASSERT_EQ(bench.write(0x6040, 0, 0x4F, 2), 0U);
  };
  go(4000);  // the first: there is no target before
  bench.run_ms(20);
  go(4000);  // from the target of the one under way
  bench.run_ms(600);
  EXPECT_NEAR(bench.read_signed(0x6064, 0), home + 8000, 10);
  go(20000);
  bench.run_ms(100);
  ASSERT_EQ(bench.write(0x6040, 0, 0x10F, 2), 0U);  // a halt does not give the target up
  bench.run_ms(300);
  ASSERT_LT(bench.read_signed(0x6064, 0), home + 25000);
  ASSERT_EQ(bench.write(0x6040, 0, 0x0F, 2), 0U);
  go(1000);
  bench.run_ms(600);
  EXPECT_NEAR(bench.read_signed(0x6064, 0), home + 29000, 10);
}

TEST(Drive, CyclicPositionFollowsAtSync) {
  Bench bench;
  bench.configure();
  ASSERT_EQ(bench.write(0x60C2, 1, 2, 1), 0U);  // 2 ms
  bench.enable(8);
  bench.nmt(0x01);
  const std::int32_t home = bench.read_signed(0x6064, 0);
  for (int i = 0; i < 500; ++i) {
    const auto target =
        home + static_cast<std::int32_t>(std::lround(3000.0 * (1.0 - std::cos(2.0 * M_PI * i / 250.0))));
    const auto bits = static_cast<std::uint32_t>(target);
    bench.send(0x305, {0x0F, 0x00, static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                       static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24)});
    bench.send(0x080, {});
    bench.run_ms(2);
    // The spline is three periods late; half a one has run since the set-point was taken, at the first poll.
    // It moves already when the loop has locked: a tenth of a millimetre takes 13 periods by the jerk limit.
    if (i > 30) {
      const double expected = 3000.0 * (1.0 - std::cos(2.0 * M_PI * (i - 2.5) / 250.0));
      ASSERT_NEAR(bench.read_signed(0x6064, 0) - home, expected, 20.0) << i;
    }
    ASSERT_LT(std::abs(bench.read_signed(0x60F4, 0)), 30) << i;
  }
  EXPECT_EQ(bench.read(0x2211, 8), 0U) << "the reference never ran dry";
  EXPECT_EQ(bench.read(0x6041, 0) & 0x1000, 0x1000U);
}

// A set-point is taken at the edge of bit 4, once: not while it stays, not while another waits, not while the
// axis is halted or not enabled; and its acknowledgement goes with the bit.
TEST(Drive, ASetPointIsTakenAtTheEdgeOfItsBit) {
  Bench bench;
  bench.configure();
  const auto control = [&](std::uint32_t word) {
    ASSERT_EQ(bench.write(0x6040, 0, word, 2), 0U);
    bench.run_ms(5);
  };
  const auto target = [&](std::int32_t counts) {
    ASSERT_EQ(bench.write(0x607A, 0, static_cast<std::uint32_t>(counts), 4), 0U);
    bench.run_ms(5);
  };
  const auto acknowledged = [&] { return (bench.read(0x6041, 0) & 0x1000U) != 0; };
  const auto arrive = [&] {
    bench.run_ms(20);
    for (int i = 0; i < 2000 && (bench.read(0x6041, 0) & 0x400U) == 0; ++i) bench.run_ms(1);
    bench.run_ms(50);
    return bench.read_signed(0x6064, 0);
  };
  // The bit rises before operation is enabled.
  ASSERT_EQ(bench.write(0x6060, 0, 1, 1), 0U);
  const std::int32_t home = bench.read_signed(0x6064, 0);
  target(home + 3000);
  for (const std::uint32_t word : {0x06U, 0x17U, 0x1FU}) control(word);
  EXPECT_FALSE(acknowledged());
  EXPECT_NEAR(arrive(), home, 15);
  control(0x0F);
  // While it stays, another target is none.
  control(0x1F);
  EXPECT_TRUE(acknowledged());
  target(home + 6000);
  EXPECT_NEAR(arrive(), home + 3000, 15);
  control(0x0F);
  EXPECT_FALSE(acknowledged());
  // While halted.
  control(0x10F);
  control(0x11F);
  EXPECT_FALSE(acknowledged());
  control(0x01F);
  EXPECT_NEAR(arrive(), home + 3000, 15);
  control(0x0F);
  // One under way, one that waits; a third is not taken, and the second holds.
  target(home + 20000);
  control(0x1F);
  control(0x0F);
  target(home + 10000);
  control(0x1F);
  EXPECT_TRUE(acknowledged());
  control(0x0F);
  target(home + 1000);
  control(0x1F);
  EXPECT_FALSE(acknowledged()) << "no room";
  bench.run_ms(200);
  static_cast<void>(arrive());
  EXPECT_NEAR(arrive(), home + 10000, 15);
}

// SYNC without a set-point in between: what is missing is extrapolated, the last one is none for its period.
TEST(Drive, AMissingSetPointIsNotTheLastOneAgain) {
  Bench bench;
  bench.configure();
  ASSERT_EQ(bench.write(0x60C2, 1, 2, 1), 0U);
  bench.enable(8);
  bench.nmt(0x01);
  const std::int32_t home = bench.read_signed(0x6064, 0);
  std::int32_t before = 0, velocity = 0;
  for (int i = 0; i < 400; ++i) {
    // Up to 0.05 m/s, 100 counts a period, and on.
    const std::int32_t wanted = home + (i < 20    ? 0
                                        : i < 220 ? (i - 20) * (i - 20) / 4
                                                  : 10000 + 100 * (i - 220));
    const auto bits = static_cast<std::uint32_t>(wanted);
    const bool lost = i > 240 && i % 10 < 2;
    if (!lost)
      bench.send(0x305, {0x0F, 0x00, static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                         static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24)});
    bench.send(0x080, {});
    bench.run_ms(2);
    const std::int32_t demand = bench.loop->controller().reference().counts();
    velocity = demand - before;
    before = demand;
    if (i <= 235) continue;
    ASSERT_NEAR(velocity, 100, 4) << i;
  }
  EXPECT_EQ(bench.read(0x2211, 8), 0U) << "two are bridged";
  EXPECT_GT(bench.loop->controller().cyclic_position().bridged(), 20U);
}

TEST(Drive, QuickStopOptionZeroCutsTheCurrentAtOnce) {
  Bench bench;
  bench.configure();
  EXPECT_EQ(bench.write(0x605A, 0, 3, 2), 0x06090030U);
  ASSERT_EQ(bench.write(0x605A, 0, 0, 2), 0U);
  bench.enable(1);
  bench.write(0x607A, 0, 50000, 4);
  bench.write(0x6040, 0, 0x1F, 2);
  bench.run_ms(100);
  EXPECT_TRUE(bench.loop->motor.enabled);
  bench.write(0x6040, 0, 0x02, 2);
  bench.run_ms(1);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x40U);
  EXPECT_FALSE(bench.loop->motor.enabled);
}

TEST(Drive, AFaultGoesOutAsEmergencyAndIsReset) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  bench.nmt(0x01);
  bench.all();
  bench.loop->board_encoder.next.valid = false;
  bench.run_ms(2);
  const auto emergency = bench.all_with(0x085);
  ASSERT_EQ(emergency.size(), 1U);
  EXPECT_EQ(Bench::number(emergency[0], 0, 2), 0x7305U);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x08U);
  EXPECT_EQ(bench.read(0x603F, 0), 0x7305U);
  EXPECT_EQ(bench.read(0x2212, 1), 1U);
  bench.loop->board_encoder.next.valid = true;
  bench.write(0x6040, 0, 0x00, 2);
  bench.write(0x6040, 0, 0x80, 2);
  bench.run_ms(2);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x40U);
  EXPECT_EQ(bench.read(0x1001, 0), 0U);
}

TEST(Drive, ParametersAreLockedWhileEnabled) {
  Bench bench;
  bench.configure();
  bench.enable(1);
  EXPECT_EQ(bench.write_real(0x2000, 5, 50.0F), 0x08000022U);
  EXPECT_EQ(bench.write_real(0x2100, 2, 50.0F), 0x08000022U);
  EXPECT_EQ(bench.write(0x2140, 3, bench.read(0x2140, 1), 4), 0x08000022U);
  EXPECT_EQ(bench.write(0x1010, 1, 0x65766173, 4), 0x08000022U);
  EXPECT_EQ(Bench::number(bench.sdo(Bench::address(0xC4, 0x2141, 0)), 4), 0x08000022U);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x6F, 0x27U) << "a refused write does not stop the axis";
  EXPECT_EQ(bench.write(0x1017, 0, 50, 2), 0U) << "settings of the communication are not parameters";
}

TEST(Drive, ALostMasterStopsTheAxis) {
  Bench bench;
  bench.configure();
  bench.write(0x1016, 1, 0x00010032, 4);
  bench.enable(1);
  bench.nmt(0x01);
  bench.send(0x701, {0x05});
  bench.run_ms(100);
  EXPECT_EQ(bench.read(0x6041, 0) & 0x4F, 0x40U) << "6007h: quick stop, then switched off";
}

}  // namespace
}  // namespace slipstack::can
