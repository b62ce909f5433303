// SPDX-License-Identifier: Apache-2.0
// The reference on its way after a stream, and out of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware/control/reference/reference.h"
#include "tests/unit/draw.h"

namespace slipstack {
namespace {

// 2 m/s, 15 m/s2 and 1500 m/s3 of 1 um at 10 kHz.
constexpr float kFastest = 200.0F;
constexpr float kAcceleration = 0.15F;
constexpr float kJerk = 1.5e-3F;

// A stream ends at any time. What it accelerated with does not carry the stop beyond the largest velocity; a
// stop along the jerk limit would add a^2 / 2 j, 7.5 counts per tick here.
TEST(Tracking, AStopOutOfAStreamIsNoFasterThanTheStreamMayBe) {
  test::Draw draw(5);
  const TrackingLimits limits = TrackingLimits::of(kFastest, kAcceleration);
  const BrakingLimits braking = braking_limits(kAcceleration, kJerk);
  float fastest_at_end = 0.0F;
  for (int i = 0; i < 200; ++i) {
    ReferenceGenerator reference;
    const auto sign = static_cast<float>(draw.sign());
    StreamPoint stream{.counts = 0, .offset = 0.0F, .step = sign * 250.0F};
    const std::size_t ticks = 1000 + draw.below(500);
    ReferencePoint last;
    for (std::size_t tick = 0; tick < ticks; ++tick) {
      stream.counts = sum(stream.counts, static_cast<std::int32_t>(stream.step));
      last = reference.track(stream, limits);
    }
    fastest_at_end = std::max(fastest_at_end, std::abs(last.velocity));
    const bool by_command = i % 2 == 0;
    if (by_command) reference.stop();
    int left = 3000;
    for (; left > 0 && !reference.standing(); --left) {
      const ReferencePoint now = reference.next(braking);
      ASSERT_LE(std::abs(now.velocity), kFastest + 1e-3F) << i;
      ASSERT_LE(std::abs(now.velocity - last.velocity), 1.01F * kAcceleration) << i;
      last = now;
    }
    EXPECT_GT(left, 0);
  }
  EXPECT_GT(fastest_at_end, 0.99F * kFastest);
}

// A stream that keeps the jerk limit, and ends while it speeds up or slows down: so does the stop.
TEST(Tracking, AStopOutOfAStreamKeepsTheJerkLimit) {
  constexpr double kMostSpeed = static_cast<double>(kFastest);
  constexpr double kMostAcceleration = 0.99 * static_cast<double>(kAcceleration);
  constexpr double kMostJerk = 0.99 * static_cast<double>(kJerk);
  test::Draw draw(6);
  const TrackingLimits limits = TrackingLimits::of(kFastest, kAcceleration);
  const BrakingLimits braking = braking_limits(kAcceleration, kJerk);
  float sharpest = 0.0F;
  for (int i = 0; i < 200; ++i) {
    ReferenceGenerator reference;
    // Up along the jerk limit to the largest acceleration, and down again before the largest velocity.
    double at = 0.0, velocity = 0.0, acceleration = 0.0;
    const std::size_t ticks = 50 + draw.below(1300);
    ReferencePoint last;
    float before = 0.0F;
    for (std::size_t tick = 0; tick < ticks; ++tick) {
      const bool up = velocity + acceleration * acceleration / (2.0 * kMostJerk) < kMostSpeed;
      acceleration = std::clamp(acceleration + (up ? kMostJerk : -kMostJerk), 0.0, kMostAcceleration);
      velocity += acceleration;
      at += velocity;
      StreamPoint stream{.counts = static_cast<std::int32_t>(at), .step = static_cast<float>(velocity)};
      stream.offset = static_cast<float>(at - stream.counts);
      const ReferencePoint now = reference.track(stream, limits);
      before = now.velocity - last.velocity;
      last = now;
    }
    for (int left = 0; left < 3000 && !reference.standing(); ++left) {
      const ReferencePoint now = reference.next(braking);
      ASSERT_LE(std::abs(now.velocity), kFastest + 1e-3F) << i;
      const float change = now.velocity - last.velocity;
      sharpest = std::max(sharpest, std::abs(change - before));
      before = change;
      last = now;
    }
    EXPECT_TRUE(reference.standing());
  }
  // What floats of a velocity of 200 have.
  EXPECT_LE(sharpest, 1.02F * kJerk + 1e-4F);
  EXPECT_GE(sharpest, 0.9F * kJerk);
}

// A path at its limits, by a clock that is right or nearly at the end of the lock range: the reference is not
// left behind, which it would have to make up for afterwards with more than the path's jerk.
TEST(Tracking, APathAtItsLimitsLeavesNothingBehind) {
  for (const double clock : {1.0, 1.0 + 4.99e-4}) {
    const TrackingLimits limits = TrackingLimits::of_path(kFastest, kAcceleration, 5e-4F);
    ReferenceGenerator reference;
    double at = 0.0, velocity = 0.0;
    double furthest = 0.0;
    for (int tick = 0; tick < 6000; ++tick) {
      // Up to the velocity limit, there for a while, and back.
      const double change = clock * clock * static_cast<double>(tick < 4000 ? kAcceleration : -kAcceleration);
      velocity = std::clamp(velocity + change, 0.0, clock * static_cast<double>(kFastest));
      at += velocity;
      StreamPoint stream{.counts = static_cast<std::int32_t>(at), .step = static_cast<float>(velocity)};
      stream.offset = static_cast<float>(at - stream.counts);
      static_cast<void>(reference.track(stream, limits));
      const double is = reference.counts() + static_cast<double>(reference.fraction());
      furthest = std::max(furthest, std::abs(is - at));
    }
    // The last bit of a velocity of 200 (half of it in the stream, half in the step), in the time constant of
    // 32 ticks.
    EXPECT_LE(furthest, 0x1p-16 * 32.0) << clock;
  }
}

// And what goes beyond is held back: by no more than the clock may be fast.
TEST(Tracking, AReferenceBehindAPathKeepsItsLimits) {
  const TrackingLimits limits = TrackingLimits::of_path(kFastest, kAcceleration, 5e-4F);
  EXPECT_NEAR(limits.velocity, kFastest, 6e-4F * kFastest);
  EXPECT_GE(limits.velocity, kFastest * (1.0F + 4.9e-4F));
  EXPECT_NEAR(limits.acceleration, kAcceleration, 1.2e-3F * kAcceleration);
  EXPECT_GE(limits.acceleration, kAcceleration * (1.0F + 9.9e-4F));
  // Room for the last bit, where that is more.
  const TrackingLimits fine = TrackingLimits::of_path(2e5F, 0.1F, 5e-4F);
  EXPECT_GE(2e5F + fine.acceleration - 2e5F, 0.1F);
}

}  // namespace
}  // namespace slipstack
