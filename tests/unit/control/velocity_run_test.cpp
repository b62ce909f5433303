// SPDX-License-Identifier: Apache-2.0
// Changes of velocity as the tick plays them: within their limits in every tick, in the shortest time,
// retargeted in motion, for ever, and to the end of a range.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "firmware/control/reference/point_to_point.h"
#include "tests/unit/control/reference_watch.h"

namespace slipstack {
namespace {

class Runner : public ReferenceWatch {
 public:
  explicit Runner(const MotionLimits& limits)
      : limits_(limits), braking_(braking_limits(limits.deceleration, limits.jerk)) {}

  PlanStatus run(float wanted, const PositionRange& range = {}) {
    return moves.run(reference, wanted, limits_, braking_, range);
  }
  void tick() { see(reference.next(braking_)); }
  void play(int number) {
    for (int i = 0; i < number; ++i) tick();
  }
  void start(std::int32_t counts) {
    reference.hold(counts);
    stands(counts);
  }

  ReferenceGenerator reference;
  PointToPoint moves;

 private:
  MotionLimits limits_;
  BrakingLimits braking_;
};

class Drawn {
 public:
  explicit Drawn(unsigned seed) : random_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  MotionLimits limits() {
    MotionLimits drawn{.velocity = static_cast<float>(log_uniform(3.0, 3e4))};
    drawn.acceleration = drawn.velocity * static_cast<float>(log_uniform(1e-3, 0.1));
    drawn.deceleration = drawn.acceleration * static_cast<float>(log_uniform(0.3, 3.0));
    drawn.jerk = drawn.acceleration * static_cast<float>(log_uniform(1e-2, 0.5));
    return drawn;
  }

 private:
  std::mt19937 random_;
};

constexpr double kRunSlack = 4e-6;  // of differences of fractions that are floats

void expect_within(const Runner& runner, const MotionLimits& limits, int i) {
  const double hardest = static_cast<double>(std::max(limits.acceleration, limits.deceleration));
  EXPECT_LE(runner.fastest, static_cast<double>(limits.velocity) * (1.0 + 1e-6) + kRunSlack) << i;
  EXPECT_LE(runner.hardest, hardest * (1.0 + 1e-6) + kRunSlack) << i;
  EXPECT_LE(runner.sharpest, static_cast<double>(limits.jerk) * (1.0 + 1e-6) + kRunSlack) << i;
}

// From one velocity to another at the moment that chance takes, in the middle of ramps too.
TEST(VelocityRun, WithinTheLimitsInEveryTickWhateverIsAskedForAndWhen) {
  Drawn drawn(11);
  double sharpest = 0.0, hardest = 0.0;
  for (int i = 0; i < 200; ++i) {
    const MotionLimits limits = drawn.limits();
    Runner runner(limits);
    runner.start(static_cast<std::int32_t>(drawn.uniform(-2e9, 2e9)));
    const double ramp = static_cast<double>(limits.velocity / limits.deceleration) +
                        static_cast<double>(limits.velocity / limits.acceleration) + 200.0;
    float wanted = 0.0F;
    for (int change = 0; change < 12; ++change) {
      wanted = static_cast<float>(drawn.uniform(-1.2, 1.2)) * limits.velocity;
      if (change % 4 == 3) wanted = 0.0F;
      ASSERT_EQ(runner.run(wanted), PlanStatus::kOk);
      runner.play(40 + static_cast<int>(drawn.uniform(0.0, 1.0) * ramp));
    }
    runner.play(static_cast<int>(4.0 * ramp + 2.0 * static_cast<double>(limits.acceleration / limits.jerk)));
    expect_within(runner, limits, i);
    wanted = std::clamp(wanted, -limits.velocity, limits.velocity);
    EXPECT_NEAR(runner.velocity, static_cast<double>(wanted),
                1e-6 * static_cast<double>(limits.velocity) + kRunSlack)
        << i;
    sharpest = std::max(sharpest, runner.sharpest / static_cast<double>(limits.jerk));
    hardest = std::max(hardest, runner.hardest / static_cast<double>(limits.acceleration));
  }
  EXPECT_GT(sharpest, 0.999) << "the limits are used";
  EXPECT_GT(hardest, 0.999);
}

// The shortest time: v / a + a / j where the acceleration limit is met, 2 sqrt(v / j) where it is not.
TEST(VelocityRun, TakesTheShortestTime) {
  for (const bool meets : {true, false}) {
    const MotionLimits limits{
        .velocity = 300.0F, .acceleration = 0.5F, .deceleration = 0.25F, .jerk = meets ? 5e-3F : 5e-4F};
    Runner runner(limits);
    runner.start(0);
    ASSERT_EQ(runner.run(200.0F), PlanStatus::kOk);
    const double expected = meets ? 200.0 / 0.5 + 0.5 / 5e-3 : 2.0 * std::sqrt(200.0 / 5e-4);
    runner.play(static_cast<int>(expected) - 5);
    EXPECT_LT(runner.velocity, 200.0 - 1e-3);
    runner.play(10);
    EXPECT_NEAR(runner.velocity, 200.0, 1e-6);
    // Slower, by the deceleration; and the other way, by both.
    ASSERT_EQ(runner.run(100.0F), PlanStatus::kOk);
    runner.hardest = 0.0;
    runner.play(3000);
    EXPECT_NEAR(runner.velocity, 100.0, 1e-6);
    EXPECT_LE(runner.hardest, 0.25 + kRunSlack);
    ASSERT_EQ(runner.run(-100.0F), PlanStatus::kOk);
    runner.play(3000);
    EXPECT_NEAR(runner.velocity, -100.0, 1e-6);
  }
}

// 2 m/s at 1 nm and 10 kHz for ten minutes: 1.2 km, the counter of 32 bits wraps 279 times.
TEST(VelocityRun, NeverEndsAndIsExactWhereCountsWrap) {
  const MotionLimits limits{2.0e5F, 150.0F, 150.0F, 1.5F};
  Runner runner(limits);
  runner.start(2'000'000'000);
  ASSERT_EQ(runner.run(2.0e5F), PlanStatus::kOk);
  runner.play(2000);
  const double from = runner.way;
  runner.fastest = runner.hardest = 0.0;
  constexpr int kTicks = 6'000'000;
  runner.play(kTicks);
  EXPECT_NEAR(runner.way - from, 2.0e5 * kTicks, 1e-2) << "what a double has of it";
  EXPECT_EQ(runner.hardest, 0.0);
  ASSERT_EQ(runner.run(-2.0e5F), PlanStatus::kOk);
  runner.play(5000);
  EXPECT_EQ(runner.velocity, -2.0e5);
  expect_within(runner, limits, 0);
}

// To either end of a range from any motion: exactly there, never beyond, and not back into it.
TEST(VelocityRun, RestsAtTheEndOfTheRange) {
  Drawn drawn(12);
  for (int i = 0; i < 200; ++i) {
    const MotionLimits limits = drawn.limits();
    Runner runner(limits);
    const double reach =
        4.0 * static_cast<double>(limits.velocity) *
        static_cast<double>(limits.velocity / limits.deceleration + limits.deceleration / limits.jerk);
    const auto end = static_cast<std::int32_t>(std::min(reach, 1e9));
    const PositionRange range{-end, end};
    runner.start(static_cast<std::int32_t>(drawn.uniform(-0.2, 0.2) * end));
    const double from = static_cast<double>(runner.reference.counts());
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    // On the way there, slower for a time, so that the plan to the end is made in motion.
    ASSERT_EQ(runner.run(static_cast<float>(sign) * limits.velocity, range), PlanStatus::kOk);
    runner.play(static_cast<int>(drawn.uniform(40.0, 1000.0)));
    ASSERT_EQ(runner.run(static_cast<float>(0.3 * sign) * limits.velocity, range), PlanStatus::kOk) << i;
    runner.play(100);
    ASSERT_EQ(runner.run(static_cast<float>(sign) * limits.velocity, range), PlanStatus::kOk) << i;
    for (std::int64_t tick = 0; tick < 50'000'000 && !runner.reference.idle(); ++tick) {
      runner.tick();
      ASSERT_LE(sign * (from + runner.way), end + 1e-3) << i;
    }
    EXPECT_EQ(runner.reference.counts(), sign > 0.0 ? end : -end) << i;
    EXPECT_EQ(runner.reference.fraction(), 0.0F);
    expect_within(runner, limits, i);
    // It is there: further out there is nothing, back there is.
    ASSERT_EQ(runner.run(static_cast<float>(sign) * limits.velocity, range), PlanStatus::kOk);
    runner.play(100);
    EXPECT_EQ(runner.reference.counts(), sign > 0.0 ? end : -end);
    ASSERT_EQ(runner.run(static_cast<float>(-sign) * limits.velocity, range), PlanStatus::kOk);
    runner.play(400);
    EXPECT_LT(sign * (from + runner.way), end - 0.5);
  }
}

// Beyond the end, since a limit switch has made the range narrower: stays there, and is not drawn back.
TEST(VelocityRun, OutsideTheRangeOnlyTheWayBackIsOpen) {
  const MotionLimits limits{.velocity = 100.0F, .acceleration = 0.5F, .deceleration = 0.5F, .jerk = 5e-3F};
  Runner runner(limits);
  runner.start(10500);
  const PositionRange range{-10000, 10000};
  ASSERT_EQ(runner.run(100.0F, range), PlanStatus::kOk);
  runner.play(1000);
  EXPECT_EQ(runner.reference.counts(), 10500);
  ASSERT_EQ(runner.run(-50.0F, range), PlanStatus::kOk);
  runner.play(3000);
  EXPECT_EQ(runner.reference.counts(), -10000);
}

// A motion that cannot end within the range is refused: the axis has to brake harder first.
TEST(VelocityRun, ARangeThatIsTooNarrowIsRefused) {
  const MotionLimits limits{.velocity = 100.0F, .acceleration = 0.5F, .deceleration = 0.5F, .jerk = 5e-3F};
  Runner runner(limits);
  runner.start(0);
  ASSERT_EQ(runner.run(100.0F), PlanStatus::kOk);
  runner.play(2000);
  const std::int32_t here = runner.reference.counts();
  for (const float wanted : {100.0F, 20.0F, 0.0F, -100.0F})
    EXPECT_EQ(runner.run(wanted, {-1000000, here + 15000 + 32 * 100 - 400}), PlanStatus::kBeyondRange)
        << wanted;
  EXPECT_EQ(runner.run(100.0F, {-1000000, here + 15000 + 32 * 100 + 400}), PlanStatus::kOk);
}

TEST(VelocityRun, ARampTooLongForItsSumsIsRefused) {
  const MotionLimits limits{.velocity = 2.0e5F, .acceleration = 1e-3F, .deceleration = 1e-3F, .jerk = 1e-6F};
  Runner runner(limits);
  runner.start(0);
  EXPECT_EQ(runner.run(2.0e5F), PlanStatus::kTooSlow);
}

// The least time to a velocity by going through time in small steps: at each, the highest acceleration from
// which velocity and acceleration can still keep their bounds. Independent of the phases.
double least_time(double v, double a, double target, const trajectory::Limits& limits) {
  const double dt = 1e-3 * std::min(limits.acceleration, limits.deceleration) / limits.jerk;
  const double jerk = limits.jerk;
  const double most = std::max({limits.acceleration, limits.deceleration, a});
  const auto may_be = [&](double velocity, double acceleration) {
    if (acceleration > most) return false;
    const double bound = velocity < 0.0 ? limits.deceleration : limits.acceleration;
    // Above its bound it falls as fast as it can.
    if (acceleration > bound + 2.0 * jerk * dt) return false;
    if (velocity + 0.5 * acceleration * std::abs(acceleration) / jerk > target) return false;
    const double later = limits.acceleration;
    return !(velocity < 0.0 && acceleration > later &&
             velocity + 0.5 * (acceleration * acceleration - later * later) / jerk > 0.0);
  };
  double time = 0.0;
  for (; v < target - 1e-3 * limits.velocity || std::abs(a) > 10.0 * jerk * dt; time += dt) {
    double next = a - jerk * dt;
    for (const double wanted : {a + jerk * dt, a}) {
      if (!may_be(v + wanted * dt, wanted)) continue;
      next = wanted;
      break;
    }
    a = next;
    v += a * dt;
    if (time > 1e9 * dt) break;
  }
  return time;
}

// From any state below the target, through zero too, where the bound of the acceleration changes.
TEST(VelocityRun, NoChangeOfVelocityIsFaster) {
  std::mt19937 random(23);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 400; ++i) {
    trajectory::Limits limits{100.0, 0.0, 0.0, 0.0};
    limits.acceleration = uniform(0.2, 2.0);
    limits.deceleration = uniform(0.2, 2.0);
    limits.jerk = uniform(0.005, 0.1);
    const double from = uniform(-60.0, 20.0);
    // Upwards, within the bound there.
    const double acceleration = uniform(0.0, from < 0.0 ? limits.deceleration : limits.acceleration);
    const double reached = from + 0.5 * acceleration * acceleration / limits.jerk;
    const double target = std::max(from, reached) + uniform(1.0, 60.0);
    // It must be able to keep the bound beyond zero.
    if (from < 0.0 && acceleration > limits.acceleration &&
        from + 0.5 * (acceleration * acceleration - limits.acceleration * limits.acceleration) / limits.jerk >
            0.0)
      continue;
    trajectory::Profile profile;
    profile.begin({0.0, from, acceleration});
    trajectory::change_velocity(profile, target, limits);
    double ticks = 0.0;
    for (std::size_t k = 0; k < profile.size(); ++k) ticks += profile[k].ticks;
    const double least = least_time(from, acceleration, target, limits);
    const double slack = 0.01 * least + 2.0;
    ASSERT_LT(ticks, least + slack) << i;
    ASSERT_GT(ticks, least - slack) << i;
  }
}

}  // namespace
}  // namespace slipstack
