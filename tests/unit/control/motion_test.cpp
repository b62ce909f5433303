// SPDX-License-Identifier: Apache-2.0
// References: they end where they were told to, within their limits, without a jump.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "firmware/app/lockstep/set_point_queue.h"
#include "firmware/control/reference/point_to_point.h"

namespace slipstack {
namespace {

ReferencePoint next(ReferenceGenerator& generator) {
  static const BrakingLimits kBraking = braking_limits(0.2F, 0.2F);
  return generator.next(kBraking);
}

double position(const ReferencePoint& point) {
  return static_cast<double>(point.counts) + static_cast<double>(point.fraction);
}

TEST(Generator, BrakesFromAnywhereWithTheGivenDeceleration) {
  for (int stop_at = 50; stop_at < 900; stop_at += 50) {
    ReferenceGenerator generator;
    generator.hold(0);
    PointToPoint moves;
    const BrakingLimits braking = braking_limits(0.2F, 0.2F);
    ASSERT_EQ(moves.move(generator, -20000, {40.0F, 0.1F, 0.1F, 0.001F}, braking), PlanStatus::kOk);
    ReferencePoint point;
    for (int i = 0; i < stop_at; ++i) point = next(generator);
    const double before = static_cast<double>(point.velocity);
    generator.stop();
    int ticks = 0;
    double last = position(point);
    for (; !generator.standing(); ++ticks) {
      point = next(generator);
      ASSERT_LE(std::abs(static_cast<double>(point.acceleration)), 0.2001);
      last = position(point);
    }
    EXPECT_NEAR(ticks, std::abs(before) / 0.2, 3.0);
    EXPECT_NEAR(position(next(generator)), last, 0.3);
    EXPECT_TRUE(generator.idle());
  }
}

// In torque mode the reference is where the axis is; the stop out of it begins where the axis goes on to be.
TEST(Generator, FollowsTheAxisAndBrakesFromItsVelocity) {
  for (const float velocity : {31.25F, -7.4F, 0.3F, 0.0F}) {
    ReferenceGenerator generator;
    generator.hold(0);
    std::int32_t axis = 500;
    for (int tick = 0; tick < 20; ++tick) {
      axis += static_cast<std::int32_t>(velocity);
      generator.follow(axis, velocity);
      const ReferencePoint point = next(generator);
      ASSERT_EQ(point.counts, axis);
      ASSERT_EQ(point.velocity, velocity);
      ASSERT_FALSE(generator.standing());
      ASSERT_FALSE(generator.braking());
    }
    // What was queued meanwhile is not played.
    ASSERT_TRUE(generator.push({.ticks = 5, .velocity = to_fixed(100.0F)}));
    generator.stop();
    double last = axis;
    double last_v = static_cast<double>(velocity);
    int ticks = 0;
    while (!generator.standing() && ++ticks < 1000) {
      const double x = position(next(generator));
      // Whole counts of the velocity where it is handed over; then 0.2 less in each tick.
      const double v = x - last;
      ASSERT_NEAR(v, last_v, 1.01) << ticks;
      if (ticks > 2) {
        ASSERT_LE(std::abs(v - last_v), 0.2 + 1e-4) << ticks;
      }
      last = x;
      last_v = v;
    }
    EXPECT_NEAR(ticks, std::abs(velocity) / 0.2F + 1.0F, 2.0F) << velocity;
    // v^2 / 2a, and the tick that had begun.
    EXPECT_NEAR(last - axis, 2.5 * static_cast<double>(velocity * std::abs(velocity)),
                1.5 + 0.6 * std::abs(static_cast<double>(velocity)))
        << velocity;
    EXPECT_TRUE(generator.idle());
    EXPECT_EQ(generator.underruns(), 0U);
  }
}

// As wide as the arithmetic.
const SetPointQueue::Bounds kNoBounds{
    {.velocity = 250000.0F, .acceleration = 1000.0F, .deceleration = 1000.0F, .jerk = 1000.0F}, 1000.0F, {}};

TEST(Stream, PassesItsSetpointsSmoothly) {
  constexpr int kPeriod = 10;
  const auto wanted = [](int k) {
    return static_cast<std::int32_t>(std::lround(4000.0 * (1.0 - std::cos(0.02 * k))));
  };
  ReferenceGenerator generator;
  generator.hold(0);
  SetPointQueue stream;
  stream.start(generator, kPeriod);
  double last = 0.0, last_v = 0.0, roughest = 0.0;
  for (int k = 1; k < 600; ++k) {
    ASSERT_TRUE(stream.push(generator, kNoBounds, wanted(k)));
    for (int i = 0; i < kPeriod; ++i) {
      const double x = position(next(generator));
      if (i == 0) {
        // Fourth differences of what is rounded to counts are up to 8.
        ASSERT_NEAR(x, wanted(std::max(k - 3, 0)), 8.0 / 36.0 + 0.01) << k;
      }
      roughest = std::max(roughest, std::abs(x - last - last_v));
      last_v = x - last;
      last = x;
    }
  }
  // The sine itself has 0.016 counts per tick^2, rounding of set-points to counts adds some 0.03.
  EXPECT_LT(roughest, 0.2);
  EXPECT_GT(roughest, 0.016);
  EXPECT_EQ(generator.underruns(), 0U);
  // Nothing more comes: braked, counted, and at rest.
  for (int i = 0; i < 100000 && !generator.idle(); ++i) next(generator);
  EXPECT_TRUE(generator.idle());
  EXPECT_EQ(generator.underruns(), 1U);
}

// 2 m/s on an encoder of 1 nm, set-points every 2 ms.
TEST(Stream, TakesTheSetpointsOfAFineEncoder) {
  constexpr int kPeriod = 20;
  constexpr std::int32_t kStep = 200000 * kPeriod;
  SetPointQueue::Bounds kFine = kNoBounds;
  kFine.motion.acceleration = kFine.motion.jerk = 20000.0F;  // it begins at once
  ReferenceGenerator generator;
  generator.hold(-1000000000);
  SetPointQueue stream;
  stream.start(generator, kPeriod);
  double last = 0.0;
  for (int k = 1; k < 400; ++k) {
    ASSERT_TRUE(stream.push(generator, kFine, -1000000000 + k * kStep)) << k;
    for (int i = 0; i < kPeriod; ++i) {
      const double x = position(next(generator));
      if (k > 6) {
        ASSERT_NEAR(x - last, 200000.0, 1e-2) << k << ' ' << i;
      }
      last = x;
    }
  }
}

// A constant acceleration, sampled with fractions of counts, comes out as one.
TEST(Stream, KeepsASteadyAcceleration) {
  constexpr int kPeriod = 20;
  constexpr double kAcceleration = 0.003;  // counts per tick^2
  ReferenceGenerator generator;
  generator.hold(-7);
  SetPointQueue stream;
  stream.start(generator, kPeriod);
  double last = -7.0, last_v = 0.0;
  for (int k = 1; k < 200; ++k) {
    const double wanted = -7.0 + 0.5 * kAcceleration * std::pow(kPeriod * k, 2);
    const auto counts = static_cast<std::int32_t>(std::floor(wanted));
    const auto fraction = static_cast<std::uint32_t>((wanted - counts) * 0x1p32);
    ASSERT_TRUE(stream.push(generator, kNoBounds, counts, fraction));
    for (int i = 0; i < kPeriod; ++i) {
      const double x = position(next(generator));
      // The first periods come from rest.
      if (k > 6) {
        ASSERT_NEAR(x - last - last_v, kAcceleration, 2e-5) << k << ' ' << i;
      }
      last_v = x - last;
      last = x;
    }
  }
}

// Set-points that leap, run away, or lead out of the range: whatever comes, the motion keeps velocity,
// acceleration and jerk, and a stop behind what was taken ends within the range.
TEST(Stream, KeepsItsBoundsWhateverComes) {
  constexpr int kPeriod = 20;
  std::mt19937 random(12);
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const SetPointQueue::Bounds bounds{
      {.velocity = 200.0F, .acceleration = 0.15F, .deceleration = 0.15F, .jerk = 1.5e-3F},
      0.15F,
      {-100000, 100000}};
  const BrakingLimits braking = braking_limits(0.15F, 1.5e-3F);
  int refused = 0, out_of_range = 0;
  for (int run = 0; run < 200; ++run) {
    ReferenceGenerator generator;
    generator.hold(0);
    SetPointQueue stream;
    stream.start(generator, kPeriod);
    // A smooth motion that may be too much in one thing, and from some set-point on leaps.
    const double amplitude = uniform(1e4, 7e4);
    const double rate = uniform(1e-4, 1.2e-3);
    const int leaps_at = static_cast<int>(uniform(100.0, 4000.0));
    double last = 0.0, last_v = 0.0, last_a = 0.0, farthest = 0.0;
    bool taken = true;
    for (int k = 1; k < 1200 && !(generator.idle() && !taken); ++k) {
      const double phase = 0.5 * std::pow(1.0 - std::cos(rate * kPeriod * k), 2.0);
      const double wanted = amplitude * phase + (k > leaps_at ? uniform(-1000.0, 1000.0) : 0.0);
      const auto counts = static_cast<std::int32_t>(std::floor(wanted));
      if (taken) {
        taken =
            stream.push(generator, bounds, counts, static_cast<std::uint32_t>((wanted - counts) * 0x1p32));
      }
      for (int i = 0; i < kPeriod; ++i) {
        const double x = position(generator.next(braking));
        ASSERT_LE(std::abs(x - last), 200.0 * 1.002) << run;
        ASSERT_LE(std::abs(x - last - last_v), 0.15 * 1.002 + 1e-4) << run;
        ASSERT_LE(std::abs(x - last - last_v - last_a), 1.5e-3 * 1.1 + 1e-4) << run << ' ' << k << ' ' << i;
        last_a = x - last - last_v;
        last_v = x - last;
        last = x;
        farthest = std::max(farthest, std::abs(x));
      }
    }
    EXPECT_LE(farthest, 100001.0) << run;
    refused += taken ? 0 : 1;
    out_of_range += 2.0 * amplitude > 1e5 ? 1 : 0;
  }
  EXPECT_GT(refused, 60);
  EXPECT_LT(refused, 180) << "and what keeps them is taken";
  EXPECT_GT(out_of_range, 20);
}

}  // namespace
}  // namespace slipstack
