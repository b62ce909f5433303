// SPDX-License-Identifier: Apache-2.0
// The reference on its way after a stream, and out of it.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace slipstack
