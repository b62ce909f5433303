// SPDX-License-Identifier: Apache-2.0
// The parts of cyclic synchronous position: the loop on SYNC, the period of a set-point, the spline, and the
// way of the reference to a stream. The whole of it behind a bus: tests/bench/cyclic_position.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "firmware/control/cyclic_position.h"

namespace slipstack {
namespace {

// Phase of the loop less that of SYNC, periods, after `syncs` of them. Arrivals are what the main loop sees:
// whole ticks. `jitter` in ticks, standard deviation.
struct Locked {
  double mean = 0.0;
  double deviation = 0.0;
  bool locked = false;
};
Locked lock(float ticks, double ppm, double jitter, int syncs) {
  SyncClock clock;
  clock.set_period(ticks, 1e-4F);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, jitter);
  double sum = 0.0, squares = 0.0;
  int counted = 0;
  for (int n = 1; n <= syncs; ++n) {
    const double true_tick = 1000.5 + n * static_cast<double>(ticks) * (1.0 + 1e-6 * ppm);
    const double off = jitter > 0.0 ? normal(random) : 0.0;
    const auto tick = static_cast<std::uint32_t>(true_tick + off);
    clock.sync(tick);
    if (n < syncs / 2) continue;
    const SyncClock::Phase at = clock.at(tick);
    const double phase = static_cast<double>(static_cast<std::int32_t>(at.fraction)) * 0x1p-32 -
                         (std::floor(true_tick + off) - true_tick) / static_cast<double>(ticks);
    sum += phase;
    squares += phase * phase;
    ++counted;
  }
  const double mean = sum / counted;
  return {mean, std::sqrt(std::max(0.0, squares / counted - mean * mean)), clock.locked()};
}

TEST(SyncClock, FollowsAClockOf200PpmWithoutLag) {
  for (const double ppm : {-450.0, -200.0, 0.0, 200.0, 450.0}) {
    const Locked locked = lock(10.0F, ppm, 0.0, 40000);
    EXPECT_TRUE(locked.locked) << ppm;
    // Arrivals are read by whole ticks: half a tick is their mean, and up to half a tick their beat.
    EXPECT_NEAR(locked.mean, 0.05, 0.03) << ppm;
  }
}

TEST(SyncClock, JitterIsFilteredByTheBandwidth) {
  // 51 us at 1 ms; 0.2 Hz against the 500 Hz of white jitter.
  const Locked locked = lock(10.0F, 50.0, 0.51, 100000);
  EXPECT_TRUE(locked.locked);
  EXPECT_LT(locked.deviation, 0.005);
  EXPECT_GT(locked.deviation, 0.0005);
}

TEST(SyncClock, IsNotLockedToAnotherPeriod) {
  for (const float wrong : {0.5F, 0.67F, 1.5F, 2.0F}) {
    SyncClock clock;
    clock.set_period(20.0F, 1e-4F);
    for (int n = 1; n < 500; ++n)
      clock.sync(static_cast<std::uint32_t>(20.0F * wrong * static_cast<float>(n)));
    EXPECT_FALSE(clock.locked()) << wrong;
  }
}

TEST(SetPointPeriods, TellsTheLateFromTheLost) {
  const auto path = [](std::uint32_t n) { return static_cast<std::int32_t>(n * n / 4 + 30 * n); };
  const auto run = [&](auto period_of_arrival, auto is_lost) {
    SetPointPeriods periods;
    int wrong = 0;
    for (std::uint32_t n = 107; n < 207; ++n) {
      if (is_lost(n)) continue;
      if (periods.place(period_of_arrival(n), path(n), 1000).period != n) ++wrong;
    }
    return wrong;
  };
  const auto in_time = [](std::uint32_t n) { return n; };
  const auto never = [](std::uint32_t) { return false; };
  EXPECT_EQ(run(in_time, never), 0);
  EXPECT_EQ(run(in_time, [](std::uint32_t n) { return n % 7 == 0 || n % 7 == 1; }), 0) << "lost";
  const auto late = [](std::uint32_t n) { return n % 11 == 5 ? n + 1 : n; };
  EXPECT_EQ(run(late, never), 0) << "late by a period";
  const auto held = [](std::uint32_t n) { return n % 20 < 3 ? n / 20 * 20 + 3 : n; };
  EXPECT_EQ(run(held, never), 0) << "three come at once";
  // A master that has lost a period of its own: late for ever, until time decides.
  const auto slipped = [](std::uint32_t n) { return n < 150 ? n : n + 1; };
  EXPECT_EQ(run(slipped, never), 57 - 2);
}

TEST(SetPointSpline, PassesCubicsAndIsSmoothWhateverComes) {
  std::mt19937 random(4);
  for (const bool cubic : {true, false}) {
    SetPointSpline spline;
    const auto path = [&](std::int32_t n) {
      if (cubic) return 2 * n * n * n - 15 * n * n + 100 * n - 70000;
      return static_cast<std::int32_t>(random() % 4001) - 2000;
    };
    for (std::uint32_t n = 0; n < 4; ++n) spline.put(n, path(static_cast<std::int32_t>(n)));
    spline.start(3);
    StreamSegment last{};
    for (std::uint32_t n = 4; n < 60; ++n) {
      spline.put(n, path(static_cast<std::int32_t>(n)));
      const StreamSegment segment = spline.segment(n, 1000000);
      if (n > 8) {
        const double jump = static_cast<double>(segment.counts - last.counts) +
                            static_cast<double>(segment.b - last.b - last.d - last.s - last.k);
        EXPECT_NEAR(jump, 0.0, 2e-2) << n;
        EXPECT_NEAR(segment.d, last.d + 2.0F * last.s + 3.0F * last.k, 2e-2F) << n;
        EXPECT_NEAR(segment.s, last.s + 3.0F * last.k, 2e-2F) << n;
        if (cubic) {
          EXPECT_NEAR(segment.b, 0.0F, 1e-2F) << "it begins at the set-point " << n;
        }
      }
      last = segment;
    }
  }
}

TEST(SetPointSpline, ExtrapolatesAParabolaAndBelievesNoJump) {
  SetPointSpline spline;
  const auto path = [](std::int32_t n) { return 3 * n * n - 40 * n + 5; };
  for (std::uint32_t n = 0; n < 6; ++n) spline.put(n, path(static_cast<std::int32_t>(n)));
  EXPECT_EQ(spline.extrapolate(6, 100), path(6));
  // The last one has jumped: what follows goes on from there, straight but for the largest bend.
  spline.put(5, path(5) + 1000);
  EXPECT_EQ(spline.extrapolate(6, 10), path(5) + 1000 + (path(5) + 1000 - path(4)) + 10);
}

// A stream that jumps, stops and runs away: never more than the limits; and it is met.
TEST(Tracking, NeverBeyondTheLimitsAndMeetsTheStream) {
  std::mt19937 random(6);
  const auto uniform = [&random](double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
  };
  for (int run = 0; run < 200; ++run) {
    const TrackingLimits limits = TrackingLimits::of(uniform(5.0, 200.0), uniform(0.02, 1.0));
    double x = 0.0, r = static_cast<double>(uniform(-5e4, 5e4));
    float last = uniform(-1.0, 1.0) * limits.velocity;
    const float stream = uniform(-0.5, 0.5) * limits.velocity;
    for (int tick = 0; tick < 40000; ++tick) {
      const float step = tracking_step(static_cast<float>(r - x), stream, last, limits);
      ASSERT_LE(std::abs(step), limits.velocity * 1.00001F);
      ASSERT_LE(std::abs(step - last), limits.acceleration * 1.0001F + 1e-5F * limits.velocity);
      x += static_cast<double>(step);
      r += static_cast<double>(stream);
      last = step;
      if (tick > 20000) {
        ASSERT_LT(std::abs(r - x), 1e-2) << run;
      }
    }
  }
}

}  // namespace
}  // namespace slipstack
