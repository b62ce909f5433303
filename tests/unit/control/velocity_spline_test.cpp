// SPDX-License-Identifier: Apache-2.0
// The path of set-points of velocity: smooth, within the limits, exact in its sum; and the stream of them
// behind SYNC, followed by the reference. The whole of it behind a bus: tests/bench/cyclic_position.
#include "firmware/control/streams/velocity_spline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "firmware/control/reference/point_to_point.h"
#include "firmware/control/reference/reference.h"
#include "firmware/control/streams/cyclic_position.h"
#include "tests/unit/control/reference_watch.h"

namespace slipstack {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// Position, velocity and acceleration at the ends of a segment, counts and periods.
struct Ends {
  double x0, x1, v0, v1, a0, a1;
  static Ends of(const StreamSegment& segment) {
    const auto b = static_cast<double>(segment.b), d = static_cast<double>(segment.d);
    const auto s = static_cast<double>(segment.s), k = static_cast<double>(segment.k);
    return {b, b + d + s + k, d, d + 2.0 * s + 3.0 * k, 2.0 * s, 2.0 * s + 6.0 * k};
  }
};

TEST(VelocitySpline, IsSmoothKeepsItsLimitsAndSumsUpExactly) {
  std::mt19937 random(3);
  for (int run = 0; run < 100; ++run) {
    const double fastest = uniform(random, 5.0, 3000.0);
    const double speeding = uniform(random, 0.01, 0.5) * fastest;
    const double slowing = uniform(random, 0.01, 0.5) * fastest;
    VelocitySpline spline;
    spline.set_limits({.velocity = static_cast<float>(fastest),
                       .speeding = static_cast<float>(speeding),
                       .slowing = static_cast<float>(slowing),
                       .range = {}});
    const auto begin = static_cast<std::int32_t>(random());
    spline.start(100, {.counts = begin, .fraction = 0.25F});
    double path = 0.25, largest = 0.0;
    Ends last{};
    for (std::uint32_t n = 100; n < 400; ++n) {
      const double wanted =
          n % 17 < 9 ? 1.5 * fastest * std::sin(0.3 * n) : uniform(random, -fastest, fastest);
      spline.put(n, static_cast<float>(wanted));
      const StreamSegment segment = spline.segment(n, 0);
      const Ends ends = Ends::of(segment);
      const double at = static_cast<double>(difference(segment.counts, begin)) + ends.x0;
      const double slack = 1e-6 * fastest + 1e-6 * std::abs(path);
      if (n > 100) {
        ASSERT_NEAR(at, path, 4.0 * slack + 1e-4) << run << ' ' << n;
        ASSERT_NEAR(ends.v0, last.v1, slack);
        ASSERT_NEAR(ends.a0, last.a1, 4.0 * slack);
      }
      ASSERT_LE(std::abs(ends.v1), fastest + slack);
      ASSERT_LE(std::abs(ends.a1), std::max(speeding, slowing) + 4.0 * slack);
      path = at - ends.x0 + ends.x1;
      largest = std::max(largest, std::abs(ends.v1));
      last = ends;
    }
    EXPECT_GT(largest, 0.05 * fastest) << "it moves";
  }
}

// A constant velocity that is no whole number of counts: no acceleration at all, and the sum is exact.
TEST(VelocitySpline, AConstantVelocityHasNoRipple) {
  VelocitySpline spline;
  spline.set_limits({.velocity = 1000.0F, .speeding = 1000.0F, .slowing = 1000.0F, .range = {}});
  spline.start(0, {.counts = 7, .velocity = 24.625F});
  for (std::uint32_t n = 0; n < 100000; ++n) {
    spline.put(n, 24.625F);
    const StreamSegment segment = spline.segment(n, 0);
    ASSERT_EQ(segment.s, 0.0F);
    ASSERT_EQ(segment.k, 0.0F);
    ASSERT_EQ(static_cast<double>(segment.counts) + static_cast<double>(segment.b), 7.0 + 24.625 * n) << n;
  }
}

// It begins in the state that the reference has: place, velocity and acceleration.
TEST(VelocitySpline, BeginsInAnyState) {
  VelocitySpline spline;
  spline.set_limits({.velocity = 1000.0F, .speeding = 40.0F, .slowing = 40.0F, .range = {}});
  spline.start(50, {.counts = -300, .fraction = 2.75F, .velocity = -412.0F, .acceleration = 30.0F});
  spline.put(50, -800.0F);
  const StreamSegment segment = spline.segment(50, 0);
  const Ends ends = Ends::of(segment);
  EXPECT_NEAR(segment.counts + ends.x0, -300 + 2.75, 1e-4);
  EXPECT_NEAR(ends.v0, -412.0, 1e-3);
  EXPECT_NEAR(ends.a0, 30.0, 1e-3);
  EXPECT_NEAR(ends.a1, -40.0, 1e-3) << "as far as the limits allow";
}

// Speed is lost by the one limit and won by the other, through zero too.
TEST(VelocitySpline, SpeedIsWonAndLostByTheirOwnLimits) {
  VelocitySpline spline;
  spline.set_limits({.velocity = 1000.0F, .speeding = 10.0F, .slowing = 65.0F, .range = {}});
  spline.start(2, {});
  const auto after = [&](std::uint32_t n, float wanted) {
    spline.put(n, wanted);
    return std::lround(2.0F * spline.segment(n, 0).d);  // v[n - 2] + v[n - 1]
  };
  for (std::uint32_t n = 2; n < 12; ++n) after(n, 1000.0F);  // v[11] = 100
  after(12, -1000.0F);                                       // 35
  after(13, -1000.0F);                                       // through zero: -10, not -30
  EXPECT_EQ(after(14, -1000.0F), 35 - 10);                   // -20
  EXPECT_EQ(after(15, -1000.0F), -10 - 20);                  // -30
  EXPECT_EQ(after(16, 1000.0F), -20 - 30);                   // 10
  EXPECT_EQ(after(17, 1000.0F), -30 + 10);
  EXPECT_TRUE(spline.limited());
}

TEST(VelocitySpline, StopsAtTheEndOfTheRangeAndComesBackAtOnce) {
  std::mt19937 random(5);
  for (int run = 0; run < 100; ++run) {
    const auto change = static_cast<float>(uniform(random, 1.0, 500.0));
    const float speed = change * static_cast<float>(uniform(random, 0.5, 40.0));
    const auto end = static_cast<std::int32_t>(2.0F * speed * speed / change + 100.0F);
    const float sign = run % 2 == 0 ? 1.0F : -1.0F;
    VelocitySpline spline;
    spline.set_limits(
        {.velocity = 1.0e6F, .speeding = change, .slowing = change, .range = {-end - 7, end + 7}});
    spline.start(0, {});
    const auto turn = static_cast<std::uint32_t>(4.0F * static_cast<float>(end) / speed) + 300;
    double farthest = 0.0, at = 0.0, reversed = 0.0;
    for (std::uint32_t n = 0; n < turn + 60; ++n) {
      spline.put(n, n < turn ? sign * speed : -sign * speed);
      const StreamSegment segment = spline.segment(n, 0);
      const Ends ends = Ends::of(segment);
      at = static_cast<double>(segment.counts) + ends.x1;
      ASSERT_LE(std::abs(ends.a1), static_cast<double>(change) * 1.001 + 1e-3) << run << ' ' << n;
      farthest = std::max(farthest, static_cast<double>(sign) * at);
      if (n == turn - 1) {
        EXPECT_TRUE(spline.limited());
        EXPECT_NEAR(farthest, end + 7, 2.0 * std::sqrt(static_cast<double>(change)) + 4.0);
        reversed = at;
      }
    }
    EXPECT_LE(farthest, end + 8.0);
    EXPECT_LT(static_cast<double>(sign) * (at - reversed), -10.0) << "no time to catch up with";
  }
}

// The reference behind a stream of velocities, tick by tick.
class Stream : public ReferenceWatch {
 public:
  Stream(float highest, float hardest_allowed, std::uint32_t period)
      : period_ticks(period),
        limits_{highest, hardest_allowed, hardest_allowed, 0.05F * hardest_allowed},
        tracking_(TrackingLimits::of(highest, hardest_allowed)),
        braking_(braking_limits(hardest_allowed, 0.05F * hardest_allowed)) {
    cyclic->set_period(static_cast<float>(period), 1e-4F, highest, hardest_allowed);
    bound({});
  }
  void bound(const PositionRange& range) { path.set_limits(cyclic->velocity_limits(limits_, range)); }
  void sync(bool has_target, float counts_per_tick) {
    cyclic->sync_velocity(tick_, has_target, counts_per_tick, path,
                          [this](std::uint32_t lead) { return reference->predict(lead, braking_).motion; });
  }
  void sync_position(std::int32_t target) {
    cyclic->set_range({});
    cyclic->sync(tick_, true, target, path,
                 [this](std::uint32_t lead) { return reference->predict(lead, braking_).motion; });
  }
  void tick() {
    ++tick_;
    see(cyclic->step(tick_) ? reference->track(cyclic->point(), tracking_) : reference->next(braking_));
  }
  void period(bool has_target, float counts_per_tick) {
    sync(has_target, counts_per_tick);
    for (std::uint32_t i = 0; i < period_ticks; ++i) tick();
  }

  VelocitySpline path;
  std::unique_ptr<CyclicPosition> cyclic = std::make_unique<CyclicPosition>();
  std::unique_ptr<ReferenceGenerator> reference = std::make_unique<ReferenceGenerator>();
  std::uint32_t period_ticks;

 private:
  MotionLimits limits_;
  TrackingLimits tracking_;
  BrakingLimits braking_;
  std::uint32_t tick_ = 5000;
};

TEST(VelocityStream, TheReferenceHasTheVelocityTwoPeriodsAndAHalfLater) {
  for (const std::uint32_t period : {2U, 10U, 100U, 1000U}) {
    Stream stream(200.0F, 0.5F, period);
    stream.cyclic->start();
    for (int n = 0; n < 12; ++n) stream.period(true, 0.0F);
    ASSERT_TRUE(stream.cyclic->following()) << period;
    const double rate = std::min(0.01, 4.0 / period);  // counts per tick^2
    const double before = stream.way;
    int n = 0;
    for (; n < 40; ++n) stream.period(true, static_cast<float>(rate * period * n));
    // The point of a tick is that of its begin, and a difference of two the velocity between them.
    EXPECT_NEAR(stream.velocity, rate * period * (n - 2.5) - 1.5 * rate, 0.02 * rate * period + 2e-3)
        << period;
    EXPECT_LE(stream.hardest, 1.2 * rate + 1e-3) << period;
    EXPECT_GT(stream.way - before, 0.0);
    EXPECT_EQ(stream.cyclic->gaps(), 0U);
  }
}

// One lost set-point in fifty, some late; velocities that leap: never beyond the limits, and it moves.
TEST(VelocityStream, NeverBeyondTheLimitsWhateverComes) {
  std::mt19937 random(9);
  for (int run = 0; run < 20; ++run) {
    const auto velocity = static_cast<float>(uniform(random, 20.0, 2000.0));
    const auto acceleration = static_cast<float>(uniform(random, 1e-3, 5e-3)) * velocity;
    const auto period = static_cast<std::uint32_t>(2 + random() % 60);
    Stream stream(velocity, acceleration, period);
    stream.cyclic->start();
    float wanted = 0.0F;
    std::uint32_t late = 0;
    for (int n = 0; n < 2000; ++n) {
      if (random() % 40 == 0) wanted = static_cast<float>(uniform(random, -1.3, 1.3)) * velocity;
      const bool here = random() % 50 != 0;
      late = random() % 30 == 0 ? static_cast<std::uint32_t>(random()) % (2 * period) : 0;
      for (std::uint32_t i = 0; i < late; ++i) stream.tick();
      if (random() % 60 != 0) stream.sync(here, wanted);
      for (std::uint32_t i = late; i < period; ++i) stream.tick();
      if (n == 1000) {
        stream.cyclic->stop();
        stream.reference->stop();
        stream.cyclic->start();
      }
    }
    EXPECT_LE(stream.fastest, static_cast<double>(velocity) * 1.00001 + 1e-4) << run;
    EXPECT_LE(stream.hardest,
              static_cast<double>(acceleration) * 1.0001 + 1e-5 * static_cast<double>(velocity) + 1e-4)
        << run;
    EXPECT_GT(stream.fastest, 0.9 * static_cast<double>(velocity)) << run;
  }
}

// A stream met in motion, from a ramp: no step of the acceleration beyond what its own change asks for.
TEST(VelocityStream, MeetsAReferenceThatBrakes) {
  Stream stream(200.0F, 0.5F, 20);
  PointToPoint moves;
  for (int n = 0; n < 12; ++n) stream.period(false, 0.0F);  // SYNC runs, and is locked to
  const MotionLimits limits{200.0F, 0.5F, 0.5F, 2e-3F};
  ASSERT_EQ(moves.run(*stream.reference, 150.0F, limits, braking_limits(0.5F, 2e-3F)), PlanStatus::kOk);
  for (int n = 0; n < 60; ++n) stream.period(false, 0.0F);
  ASSERT_NEAR(stream.velocity, 150.0, 1e-3);
  stream.reference->stop();
  stream.cyclic->start();
  double sharpest = 0.0;
  double velocity = stream.velocity, acceleration = 0.0;
  stream.sync(true, 150.0F);
  for (int tick = 0; tick < 100; ++tick) {
    if (tick > 0 && tick % 20 == 0) stream.sync(true, 150.0F);
    stream.tick();
    const double now = stream.velocity - velocity;
    if (tick > 0) sharpest = std::max(sharpest, std::abs(now - acceleration));
    acceleration = now;
    velocity = stream.velocity;
  }
  // While it waits the reference brakes at full jerk, 0.025 a tick; then from 0.5 to 0.5 over a period. What
  // floats have of the place is 0.01.
  EXPECT_LE(sharpest, 2.0 * 0.5 / 20.0 + 2e-2);
  EXPECT_NEAR(stream.velocity, 150.0, 1e-2);
}

// A stream of positions that begins somewhere else and moves otherwise: approached within the limits, with an
// acceleration that does not step, and met.
TEST(PositionStream, IsApproachedWithoutAStepOfTheAcceleration) {
  std::mt19937 random(14);
  for (int run = 0; run < 60; ++run) {
    const auto period = static_cast<std::uint32_t>(10 + random() % 40);
    Stream stream(200.0F, 0.5F, period);
    PointToPoint moves;
    for (int n = 0; n < 12; ++n) stream.period(false, 0.0F);
    const BrakingLimits braking = braking_limits(0.5F, 5e-3F);
    const auto speed = static_cast<float>(uniform(random, -150.0, 150.0));
    ASSERT_EQ(moves.run(*stream.reference, speed, {200.0F, 0.5F, 0.5F, 5e-3F}, braking), PlanStatus::kOk);
    for (int n = 0; n < 100; ++n) stream.period(false, 0.0F);
    stream.reference->stop();
    stream.cyclic->start();
    stream.sharpest = 0.0;
    const double begin = stream.reference->counts() + uniform(random, -20000.0, 20000.0);
    const double step = uniform(random, -100.0, 100.0) * period;
    int n = 0;
    for (; n < 400; ++n) {
      stream.sync_position(static_cast<std::int32_t>(std::lround(begin + step * n)));
      for (std::uint32_t i = 0; i < period; ++i) stream.tick();
    }
    // Set-point n is passed at n + 3; the point is that of the tick before.
    const double now = begin + step * (n - 3) - step / period;
    const double at = stream.reference->counts() + static_cast<double>(stream.reference->fraction());
    EXPECT_NEAR(at - stream.velocity, now, 2.0) << run;
    EXPECT_LE(stream.fastest, 200.0 * 1.00001) << run;
    EXPECT_LE(stream.hardest, 0.5 * 1.0001 + 1e-2) << run;
    // From one limit to the other over a period; set-points are whole counts, which bend the spline by 3.
    const double rounding = 3.0 / (period * period);
    EXPECT_LE(stream.sharpest, 1.0 / period + rounding + 3e-2) << run << ' ' << period;
  }
}

// A set-point that comes after its segment has begun is not played over it: the stream goes on as it was.
TEST(VelocityStream, ASetPointTooLateMakesNoStep) {
  for (const int late : {4, 12, 19}) {
    Stream stream(200.0F, 0.5F, 20);
    stream.cyclic->start();
    for (int n = 0; n < 60; ++n) stream.period(true, 100.0F);
    stream.sharpest = 0.0;
    for (int n = 0; n < 40; ++n) {
      // One SYNC by more than a period late, the next in time.
      if (n % 10 == 0) {
        for (int i = 0; i < 20 + late; ++i) stream.tick();
        stream.sync(true, 100.0F + static_cast<float>(n));
        for (int i = late; i < 20; ++i) stream.tick();
        ++n;
      }
      stream.period(true, 100.0F + static_cast<float>(n));
    }
    EXPECT_EQ(stream.cyclic->gaps(), 0U) << late;
    // Velocities change by a count per tick in a period: 0.05 of acceleration, there and back in one.
    EXPECT_LE(stream.sharpest, 0.06) << late;
    EXPECT_LE(stream.hardest, 0.5 * 1.0001 + 1e-2) << late;
  }
}

TEST(VelocityStream, AGapIsAStopAndTheNextSetPointGoesOnFromThere) {
  Stream stream(200.0F, 0.5F, 20);
  stream.cyclic->start();
  for (int n = 0; n < 60; ++n) stream.period(true, 100.0F);
  ASSERT_NEAR(stream.velocity, 100.0, 1e-3);
  // Two are bridged.
  stream.period(false, 0.0F);
  stream.period(false, 0.0F);
  stream.period(true, 100.0F);
  EXPECT_EQ(stream.cyclic->gaps(), 0U);
  EXPECT_EQ(stream.cyclic->bridged(), 2U);
  for (int n = 0; n < 40; ++n) stream.period(false, 0.0F);
  EXPECT_EQ(stream.cyclic->gaps(), 1U);
  EXPECT_TRUE(stream.reference->standing());
  const double stood = stream.way;
  for (int n = 0; n < 3; ++n) stream.period(true, 0.0F);
  EXPECT_EQ(stream.way, stood);
  for (int n = 0; n < 40; ++n) stream.period(true, -50.0F);
  EXPECT_NEAR(stream.velocity, -50.0, 1e-3);
  EXPECT_LE(stream.hardest, 0.5 * 1.0001 + 1e-3);
}

}  // namespace
}  // namespace slipstack
