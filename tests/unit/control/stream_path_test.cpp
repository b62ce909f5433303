// SPDX-License-Identifier: Apache-2.0
// The path of set-points of velocity: smooth, within the limits, exact in its sum; and the stream of them
// behind SYNC, followed by the reference. The whole of it behind a bus: tests/bench/cyclic_position.
#include "firmware/control/streams/stream_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <vector>

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

// Limits of a kind: `jerk` in periods to the largest change of the velocity.
StreamPath::Limits limits_of(double velocity, double change, double periods_of_jerk, double rounding = 0.0) {
  return {.velocity = static_cast<float>(velocity),
          .speeding = static_cast<float>(change),
          .slowing = static_cast<float>(change),
          .jerk = static_cast<float>(change / periods_of_jerk),
          .rounding = static_cast<float>(rounding),
          .range = {}};
}

// What a path has done, by its segments: largest velocity, acceleration and jerk, and that nothing steps.
class Followed {
 public:
  explicit Followed(std::int32_t begin) : begin_(begin) {}
  void see(const StreamSegment& segment) {
    const Ends ends = Ends::of(segment);
    const double from = static_cast<double>(difference(segment.counts, begin_)) + ends.x0;
    if (seen_) {
      ASSERT_NEAR(from, at, 1e-3 + 1e-6 * std::abs(at));
      ASSERT_NEAR(ends.v0, velocity, 1e-4 + 2e-6 * fastest);
      ASSERT_NEAR(ends.a0, acceleration, 1e-4 + 4e-6 * fastest);
    }
    seen_ = true;
    at = from + ends.x1 - ends.x0;
    velocity = ends.v1;
    acceleration = ends.a1;
    fastest = std::max(fastest, std::abs(ends.v1));
    hardest = std::max(hardest, std::abs(ends.a1));
    sharpest = std::max(sharpest, std::abs(ends.a1 - ends.a0));
  }
  double at = 0.0, velocity = 0.0, acceleration = 0.0;
  double fastest = 0.0, hardest = 0.0, sharpest = 0.0;

 private:
  std::int32_t begin_;
  bool seen_ = false;
};

void expect_within(const Followed& path, const StreamPath::Limits& limits) {
  EXPECT_LE(path.fastest, static_cast<double>(limits.velocity) * (1.0 + 1e-5));
  EXPECT_LE(path.hardest, static_cast<double>(limits.speeding) * (1.0 + 1e-4) + 1e-5 * path.fastest);
  EXPECT_LE(path.sharpest,
            static_cast<double>(limits.jerk + limits.rounding) * (1.0 + 1e-3) + 1e-5 * path.fastest);
}

TEST(StreamPath, IsSmoothAndKeepsItsLimitsWhateverVelocitiesCome) {
  std::mt19937 random(3);
  for (int run = 0; run < 100; ++run) {
    const double fastest = uniform(random, 5.0, 3000.0);
    const auto limits = limits_of(fastest, uniform(random, 0.01, 0.5) * fastest, uniform(random, 0.5, 20.0));
    StreamPath path;
    path.set_limits(limits);
    const auto begin = static_cast<std::int32_t>(random());
    path.start(100, {.counts = begin, .fraction = 0.25F});
    Followed seen(begin);
    for (std::uint32_t n = 100; n < 600; ++n) {
      const bool leaps = n % 97 > 60;
      path.put_velocity(n, static_cast<float>(leaps ? uniform(random, -fastest, fastest)
                                                    : 1.5 * fastest * std::sin(0.05 * n)));
      seen.see(path.segment(n));
    }
    expect_within(seen, limits);
    EXPECT_GT(seen.fastest, 0.03 * fastest) << "it moves";
  }
}

// A velocity that leaps and then stays: reached in the time that the limits need, and not overshot.
TEST(StreamPath, AVelocityThatLeapsIsReachedInTimeAndNotOvershot) {
  std::mt19937 random(4);
  for (int run = 0; run < 300; ++run) {
    const double change = uniform(random, 1.0, 100.0);
    const double periods = uniform(random, 0.7, 30.0);
    const auto limits = limits_of(60.0 * change, change, periods);
    StreamPath path;
    path.set_limits(limits);
    path.start(0, {});
    const double wanted = uniform(random, 1.0, 60.0) * change;
    Followed seen(0);
    const double full = change * periods;  // velocity of both ramps together
    const double needed =
        wanted > full ? wanted / change + periods : 2.0 * std::sqrt(wanted * periods / change);
    std::uint32_t n = 0;
    for (; n < static_cast<std::uint32_t>(1.06 * needed) + 6; ++n) {
      path.put_velocity(n, static_cast<float>(wanted));
      seen.see(path.segment(n));
    }
    EXPECT_NEAR(seen.velocity, wanted, 1e-4 * wanted) << run;
    EXPECT_LE(seen.fastest, wanted * 1.0001) << run;
    for (; n < 500; ++n) path.put_velocity(n, static_cast<float>(wanted));
    EXPECT_FALSE(path.limited());
  }
}

// A constant velocity that is no whole number of counts: no acceleration at all, and the sum is exact.
TEST(StreamPath, AConstantVelocityHasNoRipple) {
  StreamPath path;
  path.set_limits(limits_of(1000.0, 1000.0, 1.0));
  path.start(0, {.counts = 7, .velocity = 24.625F});
  for (std::uint32_t n = 0; n < 100000; ++n) {
    path.put_velocity(n, 24.625F);
    const StreamSegment segment = path.segment(n);
    ASSERT_EQ(segment.s, 0.0F);
    ASSERT_EQ(segment.k, 0.0F);
    ASSERT_EQ(static_cast<double>(segment.counts) + static_cast<double>(segment.b), 7.0 + 24.625 * n) << n;
  }
}

// It begins in the state that the reference has: place, velocity and acceleration.
TEST(StreamPath, BeginsInAnyState) {
  StreamPath path;
  path.set_limits(limits_of(1000.0, 40.0, 2.0));
  path.start(50, {.counts = -300, .fraction = 2.75F, .velocity = -412.0F, .acceleration = 30.0F});
  path.put_velocity(50, -800.0F);
  const StreamSegment segment = path.segment(50);
  const Ends ends = Ends::of(segment);
  EXPECT_NEAR(segment.counts + ends.x0, -300 + 2.75, 1e-4);
  EXPECT_NEAR(ends.v0, -412.0, 1e-3);
  EXPECT_NEAR(ends.a0, 30.0, 1e-3);
  EXPECT_NEAR(ends.a1, 10.0, 1e-3) << "as far as the jerk allows";
}

// The velocity that it begins with counts as asked for: when the second set-point is lost it goes on with it.
TEST(StreamPath, GoesOnWithTheVelocityItBeganWith) {
  StreamPath path;
  path.set_limits(limits_of(1000.0, 40.0, 2.0));
  path.start(50, {.velocity = 5.0F});
  path.put_velocity(50, 5.0F);
  for (std::uint32_t n = 51; n < 53; ++n) {
    path.extrapolate_velocity(n);
    const StreamSegment segment = path.segment(n);
    EXPECT_EQ(segment.d, 5.0F) << n;
    EXPECT_EQ(segment.s, 0.0F) << n;
    EXPECT_EQ(segment.k, 0.0F) << n;
  }
}

// Speed is lost by the one limit and won by the other, through zero too.
TEST(StreamPath, SpeedIsWonAndLostByTheirOwnLimits) {
  StreamPath path;
  StreamPath::Limits limits = limits_of(1000.0, 10.0, 1e-3);
  limits.slowing = 65.0F;
  path.set_limits(limits);
  path.start(2, {});
  const auto after = [&](std::uint32_t n, float wanted) {
    path.put_velocity(n, wanted);
    return std::lround(2.0F * path.segment(n).d);  // v[n - 2] + v[n - 1]
  };
  for (std::uint32_t n = 2; n < 12; ++n) after(n, 1000.0F);  // v[11] = 100
  after(12, -1000.0F);                                       // 35
  after(13, -1000.0F);                                       // through zero: -10, not -30
  EXPECT_EQ(after(14, -1000.0F), 35 - 10);                   // -20
  EXPECT_EQ(after(15, -1000.0F), -10 - 20);                  // -30
  EXPECT_EQ(after(16, 1000.0F), -20 - 30);                   // 10
  EXPECT_EQ(after(17, 1000.0F), -30 + 10);
  EXPECT_TRUE(path.limited());
}

// Velocities between the control points of a path, oldest first: what its limits are kept by.
class Hull {
 public:
  /// The segment of each period in a row.
  void see(const StreamSegment& segment) {
    const auto d = static_cast<double>(segment.d), s = static_cast<double>(segment.s);
    if (velocities.empty()) velocities = {d - s, d + s};
    velocities.push_back(d + 3.0 * s + 6.0 * static_cast<double>(segment.k));
  }
  std::vector<double> velocities;
};

// Limits of speeding up and slowing down that differ, both ways round: speed is won by the one and lost by
// the other in every period, and each of them is used up to the end. Places and velocities that turn round,
// smoothly and in leaps, so that a stream is met, held back from and left at any speed.
TEST(StreamPath, ItsLimitsOfSpeedingAndSlowingAreItsOwnWhateverComes) {
  std::mt19937 random(7);
  double most_won = 0.0, most_lost = 0.0;
  int followed = 0;
  for (int run = 0; run < 300; ++run) {
    const double fastest = uniform(random, 50.0, 3000.0);
    StreamPath::Limits limits = limits_of(fastest, uniform(random, 0.02, 0.3) * fastest, 0.05);
    limits.slowing = limits.speeding * static_cast<float>(std::exp(uniform(random, -1.5, 1.5)));
    // A jerk of no account, or one that shapes the path.
    const double hardest = static_cast<double>(std::max(limits.speeding, limits.slowing));
    limits.jerk = static_cast<float>(hardest * (run % 3 == 0 ? uniform(random, 0.1, 0.5) : 100.0));
    const auto won = static_cast<double>(limits.speeding), lost = static_cast<double>(limits.slowing);
    StreamPath path;
    path.set_limits(limits);
    path.start(100, {});
    Hull hull;
    const bool places = run % 2 == 0;
    const double pace = uniform(random, 0.02, 0.5);
    // Of a sine at most as hard as the limits, or half as hard again.
    const double size = std::min(0.9 * fastest, uniform(random, 0.5, 1.5) * std::min(won, lost) / pace);
    double place = 0.0;
    const auto fixed = [](double counts) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(counts * 0x1p32)));
    };
    for (std::uint32_t n = 100; n < 500; ++n) {
      const bool leaps = n % 61 > 40;
      const double velocity = leaps ? uniform(random, -fastest, fastest) : size * std::sin(pace * n);
      const double before = place;
      place += velocity;
      if (places) {
        path.put_place(n, fixed(place), fixed(before));
      } else {
        path.put_velocity(n, static_cast<float>(velocity));
      }
      followed += path.limited() ? 0 : 1;
      hull.see(path.segment(n));
    }
    double before = 0.0;
    for (std::size_t i = 1; i < hull.velocities.size(); ++i) {
      const double last = hull.velocities[i - 1], now = hull.velocities[i];
      const double rounding = 1e-5 * fastest, change = now - last, jerk = change - before;
      ASSERT_LE(std::abs(jerk), static_cast<double>(limits.jerk) * 1.001 + rounding) << run << ' ' << i;
      // Where an acceleration is more than it may be from now on, the jerk limit takes it out.
      const bool taken_out =
          -jerk * (before > 0.0 ? 1.0 : -1.0) > 0.999 * static_cast<double>(limits.jerk) - rounding;
      before = change;
      if (taken_out) continue;
      if (last * now >= 0.0) {
        const double gain = std::abs(now) - std::abs(last);
        ASSERT_LE(gain, won * 1.0001 + rounding) << run << ' ' << i;
        ASSERT_LE(-gain, lost * 1.0001 + rounding) << run << ' ' << i;
        most_won = std::max(most_won, gain / won);
        most_lost = std::max(most_lost, -gain / lost);
      } else {
        // Through zero: the rest of the period is for what is won on the other side.
        ASSERT_LE(std::abs(change), lost * 1.0001 + rounding) << run << ' ' << i;
        ASSERT_LE(std::abs(now), won * 1.0001 + rounding) << run << ' ' << i;
      }
    }
  }
  EXPECT_GT(most_won, 0.99);
  EXPECT_GT(most_lost, 0.99);
  EXPECT_GT(followed, 20000) << "and what keeps them is followed";
}

// Velocities that lead out of the range at any speed: no point of the path beyond the end, and it is reached.
TEST(StreamPath, StopsAtTheEndOfTheRangeAndComesBackAtOnce) {
  std::mt19937 random(5);
  for (int run = 0; run < 300; ++run) {
    const double change = uniform(random, 1.0, 500.0);
    const double periods = uniform(random, 0.5, 15.0);
    const double speed = change * uniform(random, 0.5, 40.0);
    const auto end = static_cast<std::int32_t>(speed * speed / change + 2.0 * speed * periods + 100.0);
    const double sign = run % 2 == 0 ? 1.0 : -1.0;
    StreamPath::Limits limits = limits_of(1.0e6, change, periods);
    limits.range = {-end, end};
    StreamPath path;
    path.set_limits(limits);
    path.start(0, {});
    const auto turn = static_cast<std::uint32_t>(3.0 * end / speed) + 300;
    double reversed = 0.0;
    Followed seen(0);
    for (std::uint32_t n = 0; n < turn + 150; ++n) {
      path.put_velocity(n, static_cast<float>(n < turn ? sign * speed : -sign * speed));
      seen.see(path.segment(n));
      ASSERT_LE(sign * seen.at, end + 1e-3 + 1e-6 * end) << run << ' ' << n;
      if (n == turn - 1) {
        EXPECT_TRUE(path.limited());
        EXPECT_NEAR(sign * seen.at, end, 1.0) << run;
        reversed = seen.at;
      }
    }
    expect_within(seen, limits);
    EXPECT_LT(sign * (seen.at - reversed), -10.0) << "no time to catch up with";
  }
}

// Places that leap, from any state, to a stream that moves: within the limits, met in a time near the least,
// from one side only.
class Leap : public ::testing::TestWithParam<double> {};
TEST_P(Leap, APlaceThatLeapsIsMetWithinTheLimitsAndNotOvershot) {
  std::mt19937 random(6);
  double slowest = 0.0, fewest = 1e9;
  for (int run = 0; run < 400; ++run) {
    const double change = uniform(random, 2.0, 200.0);
    const double periods = GetParam() * uniform(random, 0.7, 1.5);
    const double fastest = change * uniform(random, 5.0, 60.0);
    const auto limits = limits_of(fastest, change, periods);
    StreamPath path;
    path.set_limits(limits);
    const bool moves = run % 2 == 1;
    const double stream = moves ? uniform(random, -0.5, 0.5) * fastest : 0.0;
    const double distance = std::exp(uniform(random, 0.0, 6.0)) * change * (run % 4 < 2 ? 1.0 : -1.0);
    const double begin = moves ? uniform(random, -0.9, 0.9) * fastest : 0.0;
    path.start(0, {.counts = 1000, .velocity = static_cast<float>(begin)});
    Followed seen(1000);
    double beyond = 0.0;
    int met = -1;
    const auto at = [&](int n) { return 1000.0 + distance + stream * n; };
    const auto fixed = [&](int n) {
      const double place = at(n);
      const double whole = std::floor(place);
      return (std::uint64_t{static_cast<std::uint32_t>(static_cast<std::int64_t>(whole))} << 32) +
             static_cast<std::uint64_t>((place - whole) * 0x1p32);
    };
    for (int n = 0; n < 4000; ++n) {
      path.put_place(static_cast<std::uint32_t>(n), fixed(n), fixed(n - 1));
      seen.see(path.segment(static_cast<std::uint32_t>(n)));
      // The segment ends a period before its control point.
      const double off = at(n - 1) - 1000.0 - seen.at;
      if (!moves) beyond = std::max(beyond, -off * (distance > 0.0 ? 1.0 : -1.0));
      if (!path.limited() && met < 0) met = n;
      if (met >= 0) {
        ASSERT_FALSE(path.limited()) << run << ": met once, met for good";
      }
    }
    ASSERT_GE(met, 0) << run;
    expect_within(seen, limits);
    EXPECT_LE(beyond, 1e-3 * std::abs(distance) + 1e-3) << run;
    if (moves) continue;
    // From rest to rest in continuous time.
    const double way = std::abs(distance);
    double least = 4.0 * std::cbrt(way * periods / (2.0 * change));
    if (way > 2.0 * change * periods * periods) {
      const double peak =
          std::min(fastest, 0.5 * change * (std::sqrt(periods * periods + 4.0 * way / change) - periods));
      least = way / peak + peak / change + periods;
    } else {
      const double peak = std::cbrt(0.25 * way * way * change / periods);
      if (peak > fastest) least = way / fastest + 2.0 * std::sqrt(fastest * periods / change);
    }
    slowest = std::max(slowest, (met - 1.0) / least);
    fewest = std::min(fewest, (met + 1.0) / least);
  }
  std::printf("jerk over %.1f periods: %.3f to %.3f of the least time\n", GetParam(), fewest, slowest);
  EXPECT_LT(slowest, 1.06);
  EXPECT_GT(fewest, 0.5) << "whole periods";
}
INSTANTIATE_TEST_SUITE_P(Periods, Leap, ::testing::Values(0.7, 3.0, 12.0, 40.0));

// The reference behind a stream of velocities, tick by tick.
class Stream : public ReferenceWatch {
 public:
  Stream(float highest, float hardest_allowed, std::uint32_t period)
      : period_ticks(period),
        limits_{highest, hardest_allowed, hardest_allowed, 0.05F * hardest_allowed},
        tracking_(TrackingLimits::of(highest, hardest_allowed)),
        braking_(braking_limits(hardest_allowed, 0.05F * hardest_allowed)) {
    cyclic->set_period(static_cast<float>(period), 1e-4F);
    bound({}, 0.0F);
  }
  void bound(const PositionRange& range, float rounding) {
    path.set_limits(cyclic->path_limits(limits_, range, rounding));
  }
  void sync(bool has_target, float counts_per_tick) {
    cyclic->sync_velocity(tick_, has_target, counts_per_tick, path,
                          [this](std::uint32_t lead) { return reference->predict(lead, braking_).motion; });
  }
  void sync_position(std::int32_t target) {
    bound({}, CyclicPosition::kRounding);
    cyclic->sync(tick_, true, target, path,
                 [this](std::uint32_t lead) { return reference->predict(lead, braking_).motion; });
  }
  void tick() {
    cyclic->poll(tick_);
    ++tick_;
    see(cyclic->step(tick_) ? reference->track(cyclic->point(), tracking_) : reference->next(braking_));
  }
  /// While nothing moves and no SYNC comes.
  void wait(std::uint32_t silent_ticks) { tick_ += silent_ticks; }
  /// Of the clock on SYNC: the period that a SYNC would belong to now.
  std::uint32_t period_now() const {
    const SyncClock::Phase now = cyclic->clock().at(tick_);
    return now.period + (now.fraction >> 31);
  }
  void period(bool has_target, float counts_per_tick) {
    sync(has_target, counts_per_tick);
    for (std::uint32_t i = 0; i < period_ticks; ++i) tick();
  }

  StreamPath path;
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

// A stream of positions that begins somewhere else, moves otherwise, and leaps under way: within the limits
// of velocity, acceleration and jerk, and met.
TEST(PositionStream, IsMetWithinTheJerkLimitAndSoAreItsLeaps) {
  std::mt19937 random(14);
  double used = 0.0;
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
    double begin = stream.reference->counts() + uniform(random, -20000.0, 20000.0);
    const double step = uniform(random, -100.0, 100.0) * period;
    int n = 0;
    for (; n < 1200; ++n) {
      if (n == 20) stream.sharpest = 0.0;  // the reference brakes until it is the stream's
      if (n == 600) begin += uniform(random, -30000.0, 30000.0);
      stream.sync_position(static_cast<std::int32_t>(std::lround(begin + step * n)));
      for (std::uint32_t i = 0; i < period; ++i) stream.tick();
    }
    // Set-point n is passed at n + 3; the point is that of the tick before.
    const double now = begin + step * (n - 3) - step / period;
    const double at = stream.reference->counts() + static_cast<double>(stream.reference->fraction());
    EXPECT_NEAR(at - stream.velocity, now, 2.0) << run;
    EXPECT_LE(stream.fastest, 200.0 * 1.00001) << run;
    EXPECT_LE(stream.hardest, 0.5 * 1.0001 + 1e-2) << run;
    // 0.025; set-points are whole counts; what floats have of the place.
    const double rounding = static_cast<double>(CyclicPosition::kRounding) / (period * period * period);
    EXPECT_LE(stream.sharpest, 0.025 + rounding + 6e-3) << run << ' ' << period;
    used = std::max(used, stream.sharpest / std::min(0.025, 0.5 / period));
  }
  EXPECT_GT(used, 0.9) << "leaps as fast as they may";
}

// What rounding set-points to whole counts, and floats behind it, make of a motion at 2 m/s: 0.5 m sin(4 t),
// against the motion itself. Less than a count of place at every resolution; of the acceleration what the
// second difference of rounded set-points has, which falls with the resolution until that of a float is left.
TEST(PositionStream, RoundingOfSetPointsByResolution) {
  struct Row {
    double place_counts, acceleration_mps2;
  };
  const auto measure = [](double resolution_m, std::uint32_t period) {
    const auto in_ticks = [&](double per_s, int power) {
      return static_cast<float>(per_s / resolution_m * std::pow(1e-4, power));
    };
    Stream stream(in_ticks(2.5, 1), in_ticks(20.0, 2), period);
    stream.cyclic->start();
    const auto place = [](double t) { return 0.5 - 0.5 * std::cos(4.0 * t); };
    const auto counts = [&](double t) { return place(t) / resolution_m; };
    std::vector<double> off, speed;
    double squares = 0.0;
    const double period_s = period * 1e-4;
    for (int n = 0; n * period_s < 3.2; ++n) {
      stream.sync_position(static_cast<std::int32_t>(std::lround(counts(n * period_s))));
      for (std::uint32_t i = 0; i < period; ++i) {
        stream.tick();
        // Set-point n is passed at n + 3; the watch is a tick behind the reference.
        const double t = (n - 3) * period_s + i * 1e-4;
        const double acceleration = stream.acceleration * resolution_m * 1e8;
        if (t < 0.8) continue;
        off.push_back(stream.way - counts(t));
        speed.push_back(2.0 * std::sin(4.0 * t));
        // Differences of the place about one tick and a half ago.
        squares += std::pow(acceleration - 8.0 * std::cos(4.0 * (t - 1e-4)), 2);
      }
    }
    // The latency of ticks is none of the rounding.
    double products = 0.0, power = 0.0, mean = 0.0;
    for (const double one : off) mean += one / static_cast<double>(off.size());
    for (std::size_t i = 0; i < off.size(); ++i) {
      products += (off[i] - mean) * speed[i];
      power += speed[i] * speed[i];
    }
    double worst = 0.0;
    for (std::size_t i = 0; i < off.size(); ++i)
      worst = std::max(worst, std::abs(off[i] - mean - products / power * speed[i]));
    return Row{worst, std::sqrt(squares / static_cast<double>(off.size()))};
  };
  std::printf("resolution  period   place   acceleration\n");
  for (const double resolution_m : {1e-6, 1e-7, 1e-8, 1e-9}) {
    for (const std::uint32_t period : {10U, 20U, 40U, 100U}) {
      const Row row = measure(resolution_m, period);
      std::printf("%7.0f nm  %4.0f ms  %6.2f counts, rms %8.2g m/s2\n", resolution_m * 1e9, period * 0.1,
                  row.place_counts, row.acceleration_mps2);
      const double period_s = period * 1e-4;
      // A sixth of the fourth difference (set_point_spline.h), and what floats have of 2 m/s.
      const double spline_m = 0.5 * std::pow(4.0 * period_s, 4) / 6.0;
      EXPECT_LT(row.place_counts, 0.9 + (1e-8 + 1.1 * spline_m) / resolution_m);
      const double rounded_mps2 = resolution_m / (period_s * period_s);
      EXPECT_LT(row.acceleration_mps2, 0.75 * rounded_mps2 + 2.5e-3);
      EXPECT_GT(row.acceleration_mps2, 0.5 * rounded_mps2) << "as the rounding of set-points makes it";
    }
  }
}

// The same of velocities: a leap is a ramp within the jerk limit.
TEST(VelocityStream, ALeapMeetsTheJerkLimit) {
  std::mt19937 random(15);
  for (int run = 0; run < 40; ++run) {
    const auto period = static_cast<std::uint32_t>(5 + random() % 60);
    Stream stream(200.0F, 0.5F, period);
    stream.cyclic->start();
    float wanted = 0.0F;
    for (int n = 0; n < 900; ++n) {
      if (n % 300 == 50) wanted = static_cast<float>(uniform(random, -200.0, 200.0));
      if (n == 40) stream.sharpest = 0.0;
      stream.period(true, wanted);
    }
    EXPECT_NEAR(stream.velocity, static_cast<double>(wanted), 1e-3) << run;
    EXPECT_LE(stream.sharpest, 0.025 + 6e-3) << run << ' ' << period;
    EXPECT_GT(stream.sharpest, 0.8 * std::min(0.025, 0.5 / period)) << run;
    EXPECT_LE(stream.hardest, 0.5 * 1.0001 + 1e-2) << run;
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

// After a lost set-point a SYNC that comes a little early is still that of its own period: what was lost is
// bridged, and the ramp goes on as if nothing had been lost.
TEST(VelocityStream, ASetPointThatComesEarlyAfterALostOneKeepsItsPeriod) {
  for (const std::uint32_t early : {1U, 2U, 4U}) {
    Stream stream(200.0F, 0.5F, 20), undisturbed(200.0F, 0.5F, 20);
    stream.cyclic->start();
    undisturbed.cyclic->start();
    for (int n = 0; n < 80; ++n) {
      const bool lost = n == 60;
      const std::uint32_t left = lost ? 20 - early : n == 61 ? 20 + early : 20;
      stream.sync(!lost, static_cast<float>(n));
      for (std::uint32_t i = 0; i < left; ++i) stream.tick();
      if (n == 61) {
        EXPECT_EQ(stream.cyclic->bridged(), 1U) << early;
      }
      undisturbed.period(true, static_cast<float>(n));
      // A count per tick in a period: set-points in the place of another would be that far off.
      if (!lost) {
        EXPECT_NEAR(stream.velocity, undisturbed.velocity, 0.05) << early << ' ' << n;
      }
    }
    EXPECT_EQ(stream.cyclic->gaps(), 0U) << early;
    EXPECT_GT(stream.velocity, 70.0) << "it moves";
  }
}

// Periods are counted modulo 2^32, segments modulo 2^31. A stream that begins when the count comes round to
// the periods of the first one (25 days at 1 ms) plays nothing that an earlier stream left.
TEST(VelocityStream, WhatAStreamLeftIsNotPlayedWhenThePeriodsComeRound) {
  constexpr std::uint32_t kRound = 0x80000000U;
  Stream stream(200.0F, 0.5F, 2);
  stream.cyclic->start();
  for (int n = 0; n < 300; ++n) stream.period(true, 20.0F);
  ASSERT_TRUE(stream.cyclic->following());
  stream.cyclic->stop();
  stream.reference->stop();
  for (int n = 0; n < 300; ++n) stream.period(false, 0.0F);
  ASSERT_TRUE(stream.reference->standing());
  stream.cyclic->start();
  stream.wait(2 * (kRound - 40 - stream.period_now()));
  while (stream.period_now() != kRound + 1) {
    ASSERT_GE(stream.period_now(), kRound - 100);
    ASSERT_LE(stream.period_now(), kRound);
    stream.period(false, 0.0F);
  }
  ASSERT_TRUE(stream.cyclic->clock().locked());
  const double stood = stream.way;
  // Its segment begins with the next period.
  stream.sync(true, 0.0F);
  stream.tick();
  EXPECT_FALSE(stream.cyclic->following());
  stream.tick();
  for (int n = 0; n < 20; ++n) stream.period(true, 0.0F);
  EXPECT_TRUE(stream.cyclic->following());
  EXPECT_EQ(stream.way, stood);
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
