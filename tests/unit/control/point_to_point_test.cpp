// SPDX-License-Identifier: Apache-2.0
// Moves as the tick plays them: they end exactly on the count, on the finest encoder too, and are retargeted
// and halted in motion without a step.
#include "firmware/control/reference/point_to_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace slipstack {
namespace {

// Measures by differences of the positions, apart from what the generator says. Positions are differences to
// the first one, so that counters may wrap.
class Player {
 public:
  explicit Player(const MotionLimits& limits) : braking_(braking_limits(limits.deceleration, limits.jerk)) {}

  void start(std::int32_t counts) {
    reference.hold(counts);
    x_ = v_ = a_ = 0.0;
    last_ = counts;
  }

  PlanStatus move(std::int32_t target, const MotionLimits& limits) {
    return moves.move(reference, target, limits, braking_);
  }
  PlanStatus halt(const MotionLimits& limits) { return moves.halt(reference, limits, braking_); }

  void tick() {
    const ReferencePoint point = reference.next(braking_);
    x_whole_ += difference(point.counts, last_);
    last_ = point.counts;
    const double x = static_cast<double>(x_whole_) + static_cast<double>(point.fraction);
    const double v = x - x_;
    const double a = v - v_;
    if (ticks > 2) {
      velocity = std::max(velocity, std::abs(v));
      if (std::abs(v) > std::abs(v_)) {
        acceleration = std::max(acceleration, std::abs(a));
      } else {
        deceleration = std::max(deceleration, std::abs(a));
      }
      jerk = std::max(jerk, std::abs(a - a_));
    }
    x_ = x;
    v_ = v;
    a_ = a;
    ++ticks;
  }

  bool play(std::int64_t longest) {
    for (std::int64_t i = 0; i < longest && !reference.idle(); ++i) tick();
    for (int i = 0; i < 3; ++i) tick();
    return reference.idle();
  }

  ReferenceGenerator reference;
  PointToPoint moves;
  std::int64_t ticks = 0;
  double velocity = 0.0, acceleration = 0.0, deceleration = 0.0, jerk = 0.0;

 private:
  BrakingLimits braking_;
  std::int64_t x_whole_ = 0;
  std::int32_t last_ = 0;
  double x_ = 0.0, v_ = 0.0, a_ = 0.0;
};

// Differences of positions whose fractions are floats, 2^-24 of a count, at three times their weight in a
// third difference.
constexpr double kSlack = 2e-6;

void expect_within(const Player& player, const MotionLimits& limits, const char* what, int i) {
  const auto bound = [](float limit) { return static_cast<double>(limit) * (1.0 + 1e-6) + kSlack; };
  EXPECT_LE(player.velocity, bound(limits.velocity)) << what << i;
  EXPECT_LE(player.acceleration, bound(std::max(limits.acceleration, limits.deceleration))) << what << i;
  EXPECT_LE(player.deceleration, bound(std::max(limits.acceleration, limits.deceleration))) << what << i;
  EXPECT_LE(player.jerk, bound(limits.jerk)) << what << i;
}

class Random {
 public:
  explicit Random(unsigned seed) : random_(seed) {}
  float log_uniform(double low, double high) {
    return static_cast<float>(
        std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(random_)));
  }
  std::int32_t whole(std::int32_t low, std::int32_t high) {
    return std::uniform_int_distribution<std::int32_t>(low, high)(random_);
  }

 private:
  std::mt19937 random_;
};

MotionLimits random_limits(Random& random) {
  MotionLimits limits{.velocity = random.log_uniform(3.0, 3e4)};
  limits.acceleration = limits.velocity * random.log_uniform(1e-3, 0.1);
  limits.deceleration = limits.acceleration * random.log_uniform(0.3, 3.0);
  limits.jerk = limits.acceleration * random.log_uniform(1e-3, 0.5);
  return limits;
}

TEST(PointToPoint, EndsExactlyAtItsTargetWithinItsLimits) {
  Random random(3);
  double fastest = 0.0, hardest = 0.0, sharpest = 0.0;
  for (int i = 0; i < 300; ++i) {
    const MotionLimits limits = random_limits(random);
    Player player(limits);
    const std::int32_t from = random.whole(-1000000000, 1000000000);
    const std::int32_t way = static_cast<std::int32_t>(random.log_uniform(1.0, 3e7)) * (i % 2 == 0 ? 1 : -1);
    player.start(from);
    ASSERT_EQ(player.move(from + way, limits), PlanStatus::kOk);
    ASSERT_TRUE(player.play(10000000)) << i;
    ASSERT_EQ(player.reference.counts(), from + way) << i;
    expect_within(player, limits, "move ", i);
    fastest = std::max(fastest, player.velocity / static_cast<double>(limits.velocity));
    hardest = std::max(hardest, player.acceleration / static_cast<double>(limits.acceleration));
    sharpest = std::max(sharpest, player.jerk / static_cast<double>(limits.jerk));
  }
  // The limits are used, not merely kept.
  EXPECT_GT(fastest, 0.999);
  EXPECT_GT(hardest, 0.999);
  EXPECT_GT(sharpest, 0.999);
}

// 2 m at 2 m/s and 15 m/s2 in counts of 1 nm, 10 kHz, there and back.
TEST(PointToPoint, MovesTwoMetresInNanometres) {
  const MotionLimits limits{2.0e5F, 150.0F, 150.0F, 1.5F};
  Player player(limits);
  player.start(-1000000000);
  for (const std::int32_t target : {1000000000, -1000000000}) {
    player.ticks = 0;
    ASSERT_EQ(player.move(target, limits), PlanStatus::kOk);
    ASSERT_TRUE(player.play(100000));
    EXPECT_EQ(player.reference.counts(), target);
    // Way over velocity, velocity over acceleration, acceleration over jerk.
    EXPECT_NEAR(static_cast<double>(player.ticks), 10000.0 + 1333.3 + 100.0, 6.0);
  }
  expect_within(player, limits, "", 0);
  EXPECT_NEAR(player.velocity, 2.0e5, 1e-3);
}

// From one end of the counter to the other, not across where it wraps.
TEST(PointToPoint, GoesToAnyCount) {
  constexpr std::int32_t kLowest = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kHighest = std::numeric_limits<std::int32_t>::max();
  const MotionLimits limits{2.0e5F, 150.0F, 150.0F, 1.5F};
  Player player(limits);
  player.start(0);
  for (const std::int32_t target : {kHighest, kLowest, kHighest, 0}) {
    const double way = std::abs(static_cast<double>(target) - static_cast<double>(player.reference.counts()));
    player.ticks = 0;
    ASSERT_EQ(player.move(target, limits), PlanStatus::kOk);
    ASSERT_TRUE(player.play(100000));
    EXPECT_EQ(player.reference.counts(), target);
    EXPECT_NEAR(static_cast<double>(player.ticks), way / 2.0e5 + 1433.3, 6.0);
  }
  expect_within(player, limits, "", 0);
}

// 200 mm at 1 mm/s in counts of 1 um: 200 s. And a day in which the tick must not drift.
TEST(PointToPoint, TakesAsLongAsItTakes) {
  MotionLimits limits{0.1F, 0.15F, 0.15F, 1.5e-3F};
  Player player(limits);
  player.start(7);
  ASSERT_EQ(player.move(200007, limits), PlanStatus::kOk);
  ASSERT_TRUE(player.play(3000000));
  EXPECT_EQ(player.reference.counts(), 200007);
  EXPECT_NEAR(static_cast<double>(player.ticks), 2.0e6, 100.0);
  limits.velocity = 2.3e-4F;  // not a whole number of 2^-44
  player.ticks = 0;
  ASSERT_EQ(player.move(207, limits), PlanStatus::kOk);
  for (std::int64_t i = 0; i < 20000000; ++i) player.tick();
  EXPECT_NEAR(static_cast<double>(player.reference.counts()), 200007 - 20000000 * 2.3e-4, 2.0);
  expect_within(player, limits = {0.1F, 0.15F, 0.15F, 1.5e-3F}, "", 0);
}

// Slow ramps: the tick's sums keep their form over minutes.
TEST(PointToPoint, RampsOverMinutes) {
  const MotionLimits limits{0.05F, 1.0e-7F, 2.0e-7F, 1.0e-12F};
  Player player(limits);
  player.start(0);
  ASSERT_EQ(player.move(20000, limits), PlanStatus::kOk);
  ASSERT_TRUE(player.play(20000000));
  EXPECT_EQ(player.reference.counts(), 20000);
  EXPECT_LE(player.velocity, 0.05 + kSlack);
  EXPECT_GT(static_cast<double>(player.ticks), 9.0e5);
}

TEST(PointToPoint, IsRetargetedAndHaltedInMotionWithoutAStep) {
  Random random(9);
  for (int i = 0; i < 300; ++i) {
    const MotionLimits limits = random_limits(random);
    Player player(limits);
    player.start(0);
    const auto span = static_cast<std::int32_t>(
        std::min(2e8F, limits.velocity * limits.velocity / limits.acceleration + 1000.0F));
    std::int32_t target = 0;
    for (int change = 0; change < 6; ++change) {
      target = random.whole(-span, span);
      ASSERT_EQ(player.move(target, limits), PlanStatus::kOk);
      const int ticks = random.whole(0, static_cast<int>(2.0F * limits.velocity / limits.acceleration));
      for (int k = 0; k < ticks; ++k) player.tick();
      if (change % 3 == 2) {
        ASSERT_EQ(player.halt(limits), PlanStatus::kOk);
        if (change == 5) {
          ASSERT_TRUE(player.play(10000000)) << i;
        }
      }
    }
    ASSERT_EQ(player.move(target, limits), PlanStatus::kOk);
    ASSERT_TRUE(player.play(10000000)) << i;
    ASSERT_EQ(player.reference.counts(), target) << i;
    expect_within(player, limits, "retargeted ", i);
    if (HasFailure()) return;
  }
}

// Whatever happens between plan and tick makes the plan void.
TEST(PointToPoint, AStopMakesAPlanVoid) {
  const MotionLimits limits{100.0F, 1.0F, 1.0F, 0.05F};
  Player player(limits);
  player.start(0);
  ASSERT_EQ(player.move(100000, limits), PlanStatus::kOk);
  for (int i = 0; i < 500; ++i) player.tick();
  ASSERT_EQ(player.move(-100000, limits), PlanStatus::kOk);
  player.tick();
  player.reference.stop();
  ASSERT_TRUE(player.play(1000));
  EXPECT_GT(player.reference.counts(), 0);
  EXPECT_EQ(player.reference.plans_taken(), 1U);
  expect_within(player, limits, "", 0);
  // And the next one is taken from there.
  ASSERT_EQ(player.move(-100000, limits), PlanStatus::kOk);
  ASSERT_TRUE(player.play(10000));
  EXPECT_EQ(player.reference.counts(), -100000);
}

// A move may end at an end of the range, from either side; one count beyond it is refused, and so is a move
// that only swings out there.
TEST(PointToPoint, TheEndsOfTheRangeAreTheLastCounts) {
  const MotionLimits limits{100.0F, 1.0F, 1.0F, 0.05F};
  const BrakingLimits braking = braking_limits(limits.deceleration, limits.jerk);
  for (const std::int32_t middle : {0, 1000000, -2000000000}) {
    for (const std::int32_t half : {3, 500, 70000}) {
      PositionRange range;
      range.lowest = middle - half;
      range.highest = middle + half;
      ReferenceGenerator reference;
      PointToPoint moves;
      reference.hold(middle);
      const auto planned = [&](std::int32_t target) {
        return moves.move(reference, target, limits, braking, range);
      };
      EXPECT_EQ(planned(range.highest + 1), PlanStatus::kBeyondRange) << half;
      EXPECT_EQ(planned(range.lowest - 1), PlanStatus::kBeyondRange) << half;
      for (const std::int32_t end : {range.highest, range.lowest, range.highest}) {
        ASSERT_EQ(planned(end), PlanStatus::kOk) << half;
        for (int tick = 0; tick < 100000 && !reference.idle(); ++tick) reference.next(braking);
        for (int tick = 0; tick < 3; ++tick) reference.next(braking);
        ASSERT_EQ(reference.counts(), end);
      }
    }
  }
}

TEST(PointToPoint, RefusesWhatItCannotPlan) {
  const MotionLimits good{100.0F, 1.0F, 1.0F, 0.05F};
  Player player(good);
  player.start(5);
  for (float MotionLimits::*limit : {&MotionLimits::velocity, &MotionLimits::acceleration,
                                     &MotionLimits::deceleration, &MotionLimits::jerk}) {
    for (const float value : {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(), 3.0e5F}) {
      MotionLimits limits = good;
      limits.*limit = value;
      EXPECT_EQ(player.move(1000, limits), PlanStatus::kBadLimits);
    }
  }
  EXPECT_EQ(player.move(2000000000, {2.0e5F, 1.0e-6F, 1.0e-6F, 1.0e-12F}), PlanStatus::kTooSlow);
  EXPECT_TRUE(player.reference.idle());
  EXPECT_EQ(player.move(5, good), PlanStatus::kOk);  // there already
  EXPECT_TRUE(player.play(10));
  EXPECT_EQ(player.reference.counts(), 5);
}

}  // namespace
}  // namespace slipstack
