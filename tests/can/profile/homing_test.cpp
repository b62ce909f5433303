// SPDX-License-Identifier: Apache-2.0
// Homing mode: every method finds its place from anywhere on the axis, and every switch that is missing or
// stuck ends as a homing error. Places and bits are those of IEC 61800-7-201; the test computes them from
// where the switches and marks stand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "sim_host/rng.h"
#include "tests/can/profile/homing_axis.h"

namespace slipstack::can {
namespace {

constexpr double kNegative_m = 0.02;
constexpr double kHomeBegin_m = 0.1;
constexpr double kHomeEnd_m = 0.112;

double mark_at_or_above(double x_m) {
  return 0.0043 + 0.015 * std::ceil((x_m - 0.0043) / 0.015);
}
double mark_at_or_below(double x_m) {
  return 0.0043 + 0.015 * std::floor((x_m - 0.0043) / 0.015);
}

struct Case {
  int method;
  double home_m;  // NaN: depends on the start
  bool rests_at_home = true;
};

// By the figures of the standard; the stroke is the axis's.
std::vector<Case> cases(double stroke_m) {
  const double positive_m = stroke_m - 0.02;
  const double left_out = mark_at_or_below(kHomeBegin_m);
  const double left_in = mark_at_or_above(kHomeBegin_m);
  const double right_in = mark_at_or_below(kHomeEnd_m);
  const double right_out = mark_at_or_above(kHomeEnd_m);
  return {{1, mark_at_or_above(kNegative_m)},
          {2, mark_at_or_below(positive_m)},
          {7, left_out},
          {8, left_in},
          {9, right_in},
          {10, right_out},
          {11, right_out},
          {12, right_in},
          {13, left_in},
          {14, left_out},
          {17, kNegative_m, false},
          {18, positive_m, false},
          {23, kHomeBegin_m},
          {24, kHomeBegin_m},
          {25, kHomeEnd_m},
          {26, kHomeEnd_m},
          {27, kHomeEnd_m},
          {28, kHomeEnd_m},
          {29, kHomeBegin_m},
          {30, kHomeBegin_m}};
}

// An edge is seen to the tick, a mark to the count.
double tolerance_m(const HomingAxis& axis) {
  return 1.5 * HomingAxis::kSlow_mps * 1e-4 + 2.0 * axis.axis.encoder_resolution_m;
}

class HomingMethods : public testing::TestWithParam<std::size_t> {};

TEST_P(HomingMethods, FindsItsPlaceFromAnywhere) {
  const double stroke_m = sim::draw_bench(sim::Setup::kPickAndPlace, 3).axis.stroke_m;
  const Case wanted = cases(stroke_m)[GetParam()];
  sim::Rng rng(static_cast<std::uint64_t>(wanted.method), "homing");
  std::vector<double> starts = {
      0.021, 0.099, 0.1001, 0.106, 0.1119, 0.113, stroke_m - 0.021, 0.0195, stroke_m - 0.0195};
  for (int i = 0; i < 4; ++i) starts.push_back(rng.uniform(0.021, stroke_m - 0.021));
  for (const double start_m : starts) {
    SCOPED_TRACE("method " + std::to_string(wanted.method) + " from " + std::to_string(start_m) + " m");
    HomingAxis axis(start_m);
    EXPECT_FALSE(axis.referenced());
    ASSERT_EQ(axis.home(wanted.method), HomingAxis::kDone);
    EXPECT_TRUE(axis.referenced());
    EXPECT_NEAR(axis.zero_m(), wanted.home_m, tolerance_m(axis));
    EXPECT_NEAR(axis.x_m(), wanted.home_m, wanted.rests_at_home ? 20e-6 : 5e-3);
    EXPECT_GT(axis.lowest_m, 0.002) << "not into the stop";
    EXPECT_LT(axis.highest_m, stroke_m - 0.002);
    EXPECT_EQ(axis.read(0x603F, 0), 0U);
  }
}
INSTANTIATE_TEST_SUITE_P(Standard, HomingMethods, testing::Range<std::size_t>(0, 20), [](const auto& which) {
  return "Method" + std::to_string(cases(0.3)[which.param].method);
});

/// How the reference goes until the home position is found: the ways in one direction, one after the other.
struct HomingWay {
  int direction = 0;
  double fastest_mps = 0.0;
  bool from_rest = false;  ///< the reference stood before, for a tick at least
};
std::vector<HomingWay> ways_to_home(HomingAxis& axis, int method) {
  std::vector<HomingWay> ways;
  EXPECT_EQ(axis.choose(method), 0U);
  axis.enable(6);
  EXPECT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
  Controller& controller = axis.loop->controller();
  bool stood = true;
  for (int ms = 0; ms < 30000 && (axis.status() & HomingAxis::kEnd) == 0; ++ms) {
    for (int tick = 0; tick < 10; ++tick) {
      axis.loop->step();
      axis.drive->after_tick();
      const ReferencePoint& now = controller.history().point(controller.ticks());
      const double velocity_mps = static_cast<double>(now.velocity) * axis.axis.encoder_resolution_m * 1e4;
      const int direction = now.velocity > 0.0F ? 1 : -1;
      if (now.velocity == 0.0F) {
        stood = true;
        continue;
      }
      if (ways.empty() || ways.back().direction != direction || stood)
        ways.push_back({direction, 0.0, stood});
      ways.back().fastest_mps = std::max(ways.back().fastest_mps, std::abs(velocity_mps));
      stood = false;
    }
    axis.now_us += 1000;
    axis.poll();
  }
  EXPECT_EQ(axis.status() & HomingAxis::kEnd, HomingAxis::kAttained);
  return ways;
}

// A switch is searched fast, and left and entered slowly, each of them from rest: where the axis turns round
// while it still moves, the switch is passed at a speed that nobody has set.
TEST(Homing, ASwitchIsLeftAndEnteredSlowlyFromRest) {
  struct Figure {
    int method;
    int search, leave, enter;  // 0: none
  };
  // The figures of the standard, from the side where the search does not meet a limit switch.
  const Figure figures[] = {{23, 1, -1, 0}, {24, 1, -1, 1},  {25, 1, 1, -1},  {26, 1, 1, 0},
                            {27, -1, 1, 0}, {28, -1, 1, -1}, {29, -1, -1, 1}, {30, -1, -1, 0},
                            {8, 1, -1, 1},  {9, 1, 1, -1},   {17, -1, 1, 0},  {18, 1, -1, 0}};
  for (const Figure& figure : figures) {
    for (const bool on_it : {false, true}) {
      SCOPED_TRACE("method " + std::to_string(figure.method) + (on_it ? " from the switch" : ""));
      if (on_it && figure.method < 20 && figure.method > 10) continue;
      HomingAxis axis(on_it ? 0.106 : (figure.search > 0 ? 0.06 : 0.15));
      const std::vector<HomingWay> ways = ways_to_home(axis, figure.method);
      std::vector<int> wanted;
      if (!on_it) wanted.push_back(figure.search);
      wanted.push_back(figure.leave);
      if (figure.enter != 0) wanted.push_back(figure.enter);
      ASSERT_EQ(ways.size(), wanted.size());
      for (std::size_t i = 0; i < ways.size(); ++i) {
        const bool searches = !on_it && i == 0;
        const double speed_mps = searches ? HomingAxis::kFast_mps : HomingAxis::kSlow_mps;
        EXPECT_EQ(ways[i].direction, wanted[i]) << i;
        EXPECT_TRUE(ways[i].from_rest) << i;
        EXPECT_LE(ways[i].fastest_mps, speed_mps * 1.001) << i;
        EXPECT_GE(ways[i].fastest_mps, speed_mps * 0.99) << i;
      }
    }
  }
}

TEST(Homing, IndexInEitherDirection) {
  for (const double start_m : {0.05, 0.0643001, 0.0642999, 0.15}) {
    HomingAxis up(start_m);
    ASSERT_EQ(up.home(34), HomingAxis::kDone);
    EXPECT_NEAR(up.zero_m(), mark_at_or_above(start_m), tolerance_m(up));
    EXPECT_NEAR(up.x_m(), mark_at_or_above(start_m), 20e-6);
    HomingAxis down(start_m);
    ASSERT_EQ(down.home(33), HomingAxis::kDone);
    EXPECT_NEAR(down.zero_m(), mark_at_or_below(start_m), tolerance_m(down));
  }
}

TEST(Homing, CurrentPositionWithAndWithoutPower) {
  for (const int method : {35, 37}) {
    HomingAxis enabled(0.123);
    ASSERT_EQ(enabled.home(method), HomingAxis::kDone);
    EXPECT_NEAR(enabled.zero_m(), 0.123, 5e-6);
    HomingAxis off(0.123);
    ASSERT_EQ(off.choose(method), 0U);
    ASSERT_EQ(off.write(0x6060, 0, 6, 1), 0U);
    off.run_ms(1);
    ASSERT_EQ(off.write(0x6040, 0, 0x10, 2), 0U);
    off.run_ms(5);
    EXPECT_EQ(off.status(), HomingAxis::kDone);
    EXPECT_TRUE(off.referenced());
    EXPECT_EQ(off.read_signed(0x6064, 0), 0);
  }
}

// What homing has found is told in its mode, until another one is entered.
TEST(Homing, AnotherModeForgetsHowItEnded) {
  HomingAxis axis(0.123);
  ASSERT_EQ(axis.home(35), HomingAxis::kDone);
  for (const std::uint32_t mode : {1U, 6U}) {
    ASSERT_EQ(axis.write(0x6060, 0, mode, 1), 0U);
    axis.run_ms(5);
  }
  EXPECT_EQ(axis.status(), HomingAxis::kReached) << "it stands, and has not been homed since";
  EXPECT_TRUE(axis.referenced());
}

TEST(Homing, EndStopsByCurrent) {
  const double stroke_m = HomingAxis(0.1).stroke_m;
  for (const int method : {-1, -2, -3, -4}) {
    SCOPED_TRACE(method);
    HomingAxis axis(method % 2 == 0 ? 0.03 : stroke_m - 0.03);
    // No limit switches there.
    axis.loop->switches->negative_m = -1.0;
    axis.loop->switches->positive_m = 1.0 + stroke_m;
    ASSERT_EQ(axis.home(method), HomingAxis::kDone);
    const bool up = method == -1 || method == -3;
    const bool index = method > -3;
    const double stop_m = up ? stroke_m : 0.0;
    const double home_m = !index ? stop_m : (up ? mark_at_or_below(stop_m) : mark_at_or_above(stop_m));
    // Pressed by some 100 N into 1 N/um.
    EXPECT_NEAR(axis.zero_m(), home_m, index ? 2.0 * tolerance_m(axis) : 300e-6);
    EXPECT_NEAR(axis.x_m(), home_m, index ? 20e-6 : 300e-6);
    EXPECT_EQ(axis.read(0x603F, 0), 0U);
  }
}

// A switch that is narrower than the stopping distance: passed over, and found again slowly.
TEST(Homing, ANarrowSwitchIsPassedOverAndFound) {
  for (const int method : {23, 24, 25, 26, 27, 30, 7}) {
    SCOPED_TRACE(method);
    HomingAxis axis(0.05);
    axis.loop->switches->home_end_m = kHomeBegin_m + 0.0005;
    ASSERT_EQ(axis.write(0x6099, 1, axis.counts(0.2), 4), 0U);
    ASSERT_EQ(axis.home(method), HomingAxis::kDone);
    const double home_m =
        method == 7 ? mark_at_or_below(kHomeBegin_m)
                    : (method == 23 || method == 24 || method == 30 ? kHomeBegin_m : kHomeBegin_m + 0.0005);
    EXPECT_NEAR(axis.zero_m(), home_m, tolerance_m(axis));
  }
}

TEST(Homing, TheHomeOffsetShiftsZero) {
  HomingAxis axis(0.05);
  ASSERT_EQ(axis.write(0x607C, 0, axis.counts(0.030), 4), 0U);
  ASSERT_EQ(axis.home(23), HomingAxis::kDone);
  // Zero position = home position + home offset.
  EXPECT_NEAR(axis.zero_m(), kHomeBegin_m + 0.030, tolerance_m(axis));
  EXPECT_NEAR(axis.read_signed(0x6064, 0), -0.030 / axis.axis.encoder_resolution_m, 100.0);
}

// Moves afterwards count from the new zero: profile position and cyclic position alike.
TEST(Homing, MovesCountFromZero) {
  HomingAxis axis(0.05);
  ASSERT_EQ(axis.home(23), HomingAxis::kDone);
  axis.enable(1);
  ASSERT_EQ(axis.write(0x6081, 0, axis.counts(0.1), 4), 0U);
  ASSERT_EQ(axis.write(0x6083, 0, axis.counts(2.0), 4), 0U);
  ASSERT_EQ(axis.write(0x6084, 0, axis.counts(2.0), 4), 0U);
  ASSERT_EQ(axis.write(0x607A, 0, axis.counts(0.02), 4), 0U);
  ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
  axis.run_ms(1500);
  EXPECT_NEAR(axis.x_m(), kHomeBegin_m + 0.02, 10e-6);
  EXPECT_NEAR(axis.read_signed(0x6064, 0), axis.counts(0.02), 100.0);
  EXPECT_NEAR(axis.read_signed(0x2200, 9), axis.counts(0.02), 2.0);
  ASSERT_EQ(axis.write(0x6060, 0, 8, 1), 0U);
  axis.run_ms(2);
  EXPECT_NEAR(axis.read_signed(0x607A, 0), axis.counts(0.02), 100.0) << "starts as the actual value";
}

// 607Dh counts from zero wherever that lies in the encoder's counts; its last numbers bound nothing.
TEST(Homing, SoftwareLimitsCountFromZeroAndTheLastNumbersBoundNothing) {
  constexpr std::uint32_t kLowest = 0x80000000U, kHighest = 0x7FFFFFFFU;
  for (const std::int32_t offset : {-40000, 0, 30000}) {
    HomingAxis axis(0.123);
    ASSERT_EQ(axis.write(0x607C, 0, static_cast<std::uint32_t>(offset), 4), 0U);
    ASSERT_EQ(axis.home(37), HomingAxis::kDone);
    ASSERT_EQ(axis.write(0x6060, 0, 1, 1), 0U);  // homing itself is not bounded
    const Controller& controller = axis.loop->controller();
    const std::int32_t origin = controller.position().origin();
    for (const std::uint32_t low : {kLowest, 0xFFFFFC18U}) {
      for (const std::uint32_t high : {kHighest, 2000U}) {
        ASSERT_EQ(axis.write(0x607D, 1, kLowest, 4), 0U);
        ASSERT_EQ(axis.write(0x607D, 2, high, 4), 0U);
        ASSERT_EQ(axis.write(0x607D, 1, low, 4), 0U);
        axis.run_ms(2);
        EXPECT_EQ(controller.range().lowest, low == kLowest ? PositionRange::kNoLowest : origin - 1000)
            << offset;
        EXPECT_EQ(controller.range().highest, high == kHighest ? PositionRange::kNoHighest : origin + 2000)
            << offset;
      }
    }
  }
}

TEST(Homing, OtherMethodsAreRefused) {
  HomingAxis axis(0.1);
  std::vector<int> supported;
  const std::uint32_t count = axis.read(0x60E3, 0);
  for (std::uint32_t sub = 1; sub <= count; ++sub) {
    supported.push_back(static_cast<std::int8_t>(axis.read(0x60E3, static_cast<std::uint8_t>(sub))));
  }
  for (int method = -128; method < 128; ++method) {
    const bool listed =
        method == 0 || std::find(supported.begin(), supported.end(), method) != supported.end();
    EXPECT_EQ(axis.choose(method), listed ? 0U : 0x06090030U) << method;
  }
  for (const int wanted : {1, 2, 7, 11, 17, 18, 23, 27, 33, 34, 35, 37, -1, -2, -3, -4}) {
    EXPECT_NE(std::find(supported.begin(), supported.end(), wanted), supported.end()) << wanted;
  }
  EXPECT_EQ(axis.read(0x6502, 0) & 0x20U, 0x20U);
}

TEST(Homing, NoMethodIsAnError) {
  HomingAxis axis(0.1);
  EXPECT_EQ(axis.home(0), HomingAxis::kError | HomingAxis::kReached);
  EXPECT_FALSE(axis.referenced());
}

TEST(Homing, ASwitchThatIsNotWiredIsAnErrorBeforeAnythingMoves) {
  for (const int method : {1, 17, 2, 18, 23, 7}) {
    HomingAxis axis(0.06);
    for (std::uint8_t sub = 1; sub <= 3; ++sub) ASSERT_EQ(axis.write(0x2010, sub, 0, 1), 0U);
    ASSERT_EQ(axis.write(0x2140, 3, axis.read(0x2140, 1), 4), 0U);
    axis.run_ms(2);
    EXPECT_EQ(axis.home(method), HomingAxis::kError | HomingAxis::kReached);
    EXPECT_NEAR(axis.x_m(), 0.06, 20e-6);
  }
}

TEST(Homing, AHomeSwitchThatNeverComes) {
  for (const int method : {7, 11, 23, 24, 25, 26, 27, 30}) {
    SCOPED_TRACE(method);
    HomingAxis axis(0.06);
    axis.loop->switches->home_begin_m = 5.0;
    axis.loop->switches->home_end_m = 6.0;
    EXPECT_EQ(axis.home(method), HomingAxis::kError | HomingAxis::kReached);
    EXPECT_FALSE(axis.referenced());
    EXPECT_GT(axis.lowest_m, 0.002) << "stopped at the limit switch";
    EXPECT_LT(axis.highest_m, axis.stroke_m - 0.002);
    EXPECT_EQ(axis.read(0x603F, 0), 0U) << "no fault of the drive";
    EXPECT_EQ(axis.read(0x6041, 0) & 0x6FU, 0x27U) << "still enabled";
  }
}

TEST(Homing, AHomeSwitchThatIsStuck) {
  for (const int method : {7, 11, 23, 24, 25, 26, 27, 30}) {
    SCOPED_TRACE(method);
    HomingAxis axis(0.06);
    axis.loop->switches->home_begin_m = -5.0;
    axis.loop->switches->home_end_m = 5.0;
    EXPECT_EQ(axis.home(method), HomingAxis::kError | HomingAxis::kReached);
    EXPECT_FALSE(axis.referenced());
    EXPECT_GT(axis.lowest_m, 0.002);
    EXPECT_LT(axis.highest_m, axis.stroke_m - 0.002);
  }
}

// Stuck, it sends the axis to the other one; that one ends it.
TEST(Homing, ALimitSwitchThatIsStuck) {
  HomingAxis axis(0.06);
  axis.loop->switches->negative_m = 5.0;
  EXPECT_EQ(axis.home(17), HomingAxis::kError | HomingAxis::kReached);
  EXPECT_LT(axis.highest_m, axis.stroke_m - 0.002);
  HomingAxis other(0.2);
  other.loop->switches->positive_m = -5.0;
  EXPECT_EQ(other.home(18), HomingAxis::kError | HomingAxis::kReached);
  EXPECT_GT(other.lowest_m, 0.002);
}

TEST(Homing, AnIndexThatNeverComes) {
  for (const int method : {33, 34, 1, 7}) {
    HomingAxis axis(0.15);
    axis.loop->marks.reset();
    EXPECT_EQ(axis.home(method), HomingAxis::kError | HomingAxis::kReached) << method;
    EXPECT_FALSE(axis.referenced());
  }
}

// A limit switch that is never active: the axis ends at the mechanical stop by its fault, or out of time.
TEST(Homing, OutOfTime) {
  HomingAxis axis(0.2);
  axis.loop->switches->negative_m = -5.0;
  ASSERT_EQ(axis.write_real(0x2011, 1, 0.5F), 0U);
  EXPECT_EQ(axis.home(17), HomingAxis::kError | HomingAxis::kReached);
  EXPECT_GT(axis.x_m(), 0.13);
  EXPECT_LT(axis.x_m(), 0.17) << "half a second at 0.1 m/s";
  EXPECT_FALSE(axis.referenced());
}

// The time counts from its own begin, not from that of the drive.
TEST(Homing, InTimeHoweverLongTheDriveHasBeenOn) {
  HomingAxis axis(0.06);
  ASSERT_EQ(axis.write_real(0x2011, 1, 4.0F), 0U);
  axis.run_ms(5000);
  EXPECT_EQ(axis.home(23), HomingAxis::kDone);
  axis.run_ms(5000);
  EXPECT_EQ(axis.start(), HomingAxis::kDone) << "and again";
}

TEST(Homing, StatusWhileItRunsAndWhenItIsInterrupted) {
  HomingAxis axis(0.2);
  ASSERT_EQ(axis.choose(23), 0U);
  axis.enable(6);
  EXPECT_EQ(axis.status(), HomingAxis::kReached) << "not started";
  ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
  axis.run_ms(200);
  EXPECT_EQ(axis.status(), 0U) << "in progress";
  ASSERT_EQ(axis.write(0x6040, 0, 0x0F, 2), 0U);
  axis.run_ms(20);
  EXPECT_EQ(axis.status(), 0U) << "still moving";
  axis.run_ms(400);
  EXPECT_EQ(axis.status(), HomingAxis::kReached) << "interrupted";
  const double there_m = axis.x_m();
  axis.run_ms(200);
  EXPECT_NEAR(axis.x_m(), there_m, 5e-6);
  // Halt does the same; when it is released, homing begins anew.
  ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
  axis.run_ms(100);
  ASSERT_EQ(axis.write(0x6040, 0, 0x11F, 2), 0U);
  axis.run_ms(400);
  EXPECT_EQ(axis.status(), HomingAxis::kReached);
  EXPECT_EQ(axis.start(), HomingAxis::kDone);
  EXPECT_NEAR(axis.zero_m(), kHomeBegin_m, tolerance_m(axis));
}

TEST(Homing, DisablingEndsIt) {
  HomingAxis axis(0.2);
  ASSERT_EQ(axis.choose(23), 0U);
  axis.enable(6);
  ASSERT_EQ(axis.write(0x6040, 0, 0x1F, 2), 0U);
  axis.run_ms(200);
  ASSERT_EQ(axis.write(0x6040, 0, 0x06, 2), 0U);
  axis.run_ms(300);
  EXPECT_EQ(axis.status(), HomingAxis::kReached);
  EXPECT_FALSE(axis.referenced());
  EXPECT_EQ(axis.read(0x603F, 0), 0U);
}

}  // namespace
}  // namespace slipstack::can
