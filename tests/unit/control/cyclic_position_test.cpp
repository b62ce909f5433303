// SPDX-License-Identifier: Apache-2.0
// The parts of cyclic synchronous position: the loop on SYNC, the period of a set-point, the spline, and the
// way of the reference to a stream. The whole of it behind a bus: tests/bench/cyclic_position.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "firmware/control/bounds/position_range.h"
#include "firmware/control/bounds/stopping_distance.h"
#include "firmware/control/reference/braking.h"
#include "firmware/control/streams/cyclic_position.h"

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
  std::uint32_t passed = 1000;
  for (int n = 1; n <= syncs; ++n) {
    const double true_tick = 1000.5 + n * static_cast<double>(ticks) * (1.0 + 1e-6 * ppm);
    const double off = jitter > 0.0 ? normal(random) : 0.0;
    const auto tick = static_cast<std::uint32_t>(true_tick + off);
    for (; passed < tick; ++passed) clock.follow(passed);
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

// SYNCs out of place correct the rate, and no tick of it is much longer than the one before.
TEST(SyncClock, ASyncOutOfPlaceStepsNoVelocity) {
  for (const std::uint32_t period : {10U, 100U, 1000U}) {
    SyncClock clock;
    clock.set_period(static_cast<float>(period), 1e-4F);
    double largest_step = 0.0, largest_change = 0.0, before = 0.0;
    std::uint32_t tick = 0;
    const auto phase = [&] {
      const SyncClock::Phase at = clock.at(tick);
      return at.period + at.fraction * 0x1p-32;
    };
    double last = 0.0;
    for (std::uint32_t n = 1; n <= 400; ++n) {
      const std::uint32_t late = n > 40 && n % 20 == 0 ? 3 * period / 10 : 0;
      for (; tick < n * period + late; ++tick) {
        const double now = phase();
        const double rate = (now - last) * period;  // 1 is nominal
        if (n > 40) {
          largest_step = std::max(largest_step, std::abs(rate - before));
          largest_change = std::max(largest_change, std::abs(rate - 1.0));
        }
        before = rate;
        last = now;
        clock.follow(tick);
      }
      --tick;
      clock.sync(tick);
      ++tick;
    }
    EXPECT_TRUE(clock.locked());
    // A rate of 32 bits has 10^-9 of the period; the rest comes about in a period.
    EXPECT_LE(largest_step, 1.1 * largest_change / period + 2e-9 * period) << period;
    EXPECT_GT(largest_change, 1e-6) << period << ": it is corrected";
    std::printf("period %u: velocity corrected by %.2g, by %.2g in a tick\n", period, largest_change,
                largest_step);
  }
}

// Eight SYNCs in a row make the lock, wherever the first one lies; a silence within a period takes none.
TEST(SyncClock, IsLockedAfterEightSyncsInARow) {
  for (std::uint32_t first = 1; first < 60; ++first) {
    SyncClock clock;
    clock.set_period(20.0F, 1e-4F);
    int syncs = 0;
    for (std::uint32_t tick = first; !clock.locked() && syncs < 20; tick += 20) {
      clock.sync(tick);
      ++syncs;
    }
    EXPECT_EQ(syncs, SyncClock::kAcquired) << first;
  }
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

// Paths that are bent as much as may be: however many set-points are lost before one, and by how much it is
// late itself, its place says which it is.
TEST(SetPointPeriods, ABentPathTellsHowManyWereLost) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int late_ones = 0;
  for (int run = 0; run < 400; ++run) {
    const double velocity = 2000.0 * any(random), bend = 300.0 * any(random);
    const auto path = [&](std::uint32_t n) {
      const double at = static_cast<double>(n) - 100.0;
      return static_cast<std::int32_t>(std::lround(velocity * at + 0.5 * bend * at * at));
    };
    SetPointPeriods periods;
    for (std::uint32_t n = 100; n < 106; ++n) periods.place(n, path(n), 1 << 20);
    // Places that may be taken for one another are for time to tell.
    double nearest = 1e9;
    for (std::uint32_t n = 105; n < 110; ++n)
      nearest = std::min(nearest, std::abs(static_cast<double>(path(n + 1)) - path(n)));
    if (nearest < 50.0) continue;
    const auto lost = static_cast<std::uint32_t>(run % 3), late = static_cast<std::uint32_t>(run / 3 % 2);
    const std::uint32_t n = 106 + lost;
    ASSERT_EQ(periods.place(n + late, path(n), 1 << 20).period, n) << run << ' ' << velocity << ' ' << bend;
    late_ones += late > 0 ? 1 : 0;
  }
  EXPECT_GT(late_ones, 100);
}

// A uniform cubic B-spline passes c + (second difference of c) / 6: on a cubic that is the set-point.
TEST(SetPointSpline, PassesCubics) {
  SetPointSpline spline;
  const auto path = [](std::int32_t n) { return 2 * n * n * n - 15 * n * n + 100 * n - 70000; };
  for (std::uint32_t n = 0; n < 4; ++n) spline.put(n, path(static_cast<std::int32_t>(n)));
  spline.start(3);
  const auto control = [&](std::uint32_t n) {
    return static_cast<double>(static_cast<std::int64_t>(spline.place(n))) * 0x1p-32;
  };
  for (std::uint32_t n = 4; n < 60; ++n) {
    spline.put(n, path(static_cast<std::int32_t>(n)));
    spline.lean(n, 1000000);
    if (n < 9) continue;
    const double bend = control(n) - 2.0 * control(n - 1) + control(n - 2);
    EXPECT_NEAR(control(n - 1) + bend / 6.0, path(static_cast<std::int32_t>(n) - 1), 1e-6) << n;
  }
}

// Set-points that leap are leant out for by no more than the largest bend.
TEST(SetPointSpline, LeansOutByNoMoreThanTheLargestBend) {
  std::mt19937 random(4);
  SetPointSpline spline;
  for (std::uint32_t n = 0; n < 4; ++n) spline.put(n, 0);
  spline.start(3);
  for (std::uint32_t n = 4; n < 60; ++n) {
    const auto place = static_cast<std::int32_t>(random() % 40000001) - 20000000;
    spline.put(n, place);
    spline.lean(n, 30);
    EXPECT_NEAR(static_cast<double>(static_cast<std::int64_t>(spline.place(n))) * 0x1p-32, place, 10.001);
  }
}

// Set-points that are mirrored make the mirrored path.
TEST(SetPointSpline, IsTheSameBothWays) {
  std::mt19937 random(15);
  for (int run = 0; run < 20; ++run) {
    SetPointSpline up, down;
    const auto put = [&](std::uint32_t n, std::int32_t place) {
      up.put(n, place);
      down.put(n, -place);
    };
    for (std::uint32_t n = 0; n < 4; ++n) put(n, 0);
    up.start(3);
    down.start(3);
    for (std::uint32_t n = 4; n < 60; ++n) {
      put(n, static_cast<std::int32_t>(random() % 2001) - 1000);
      const auto bend = static_cast<std::int32_t>(random() % 3000);
      up.lean(n, bend);
      down.lean(n, bend);
      // Sixths of a count are rounded down.
      const auto both = static_cast<std::int64_t>(up.place(n) + down.place(n));
      ASSERT_NEAR(static_cast<double>(both) * 0x1p-32, 0.0, 1e-6) << run << ' ' << n;
      const std::int32_t next = up.extrapolate(n + 1, bend);
      ASSERT_NEAR(next, -down.extrapolate(n + 1, bend), 1) << "whole counts";
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

// A stream of set-points at rest, at the shortest period there is: the fewer ticks in a period, the sooner
// its number comes round.
class RestingStream {
 public:
  static constexpr auto kPeriod = static_cast<std::uint32_t>(SyncClock::kShortestTicks);

  RestingStream() {
    cyclic.set_period(SyncClock::kShortestTicks, 1e-4F);
    path_.set_limits(
        cyclic.path_limits({250.0F, 0.5F, 0.5F, 0.005F}, PositionRange{}, CyclicPosition::kRounding));
    cyclic.start();
  }
  // Where the reference rests and the set-points lie.
  void rest_at(std::int32_t counts) { place_ = counts; }
  void sync(bool has_target) {
    cyclic.sync(tick, has_target, place_, path_, [this](std::uint32_t) {
      Motion motion{};
      motion.counts = place_;
      return motion;
    });
  }
  // SYNC, and the ticks until the next.
  void periods(int count, bool has_target) {
    for (; count > 0; --count) {
      sync(has_target);
      for (std::uint32_t i = 0; i < kPeriod; ++i) step();
    }
  }
  void step() {
    cyclic.poll(++tick);
    if (!cyclic.step(tick)) return;
    ++followed;
    const StreamPoint at = cyclic.point();
    farthest = std::max(farthest,
                        std::abs(static_cast<double>(at.counts) - place_ + static_cast<double>(at.offset)));
  }

  CyclicPosition cyclic;
  std::uint32_t tick = 1000;
  int followed = 0;       // ticks that a stream led the reference in
  double farthest = 0.0;  // how far from where it rests, counts

 private:
  StreamPath path_;
  std::int32_t place_ = 0;
};

// The stamp of a segment is its period modulo 2^31. A stream that begins in whichever period after a long
// time without one: the tick takes no segment of the stream before.
TEST(CyclicPosition, AStreamBeginsWithNoSegmentOfAnEarlierOne) {
  for (std::uint32_t lag = 0; lag < 64; ++lag) {
    RestingStream stream;
    stream.rest_at(100000);
    stream.periods(40, true);
    ASSERT_TRUE(stream.cyclic.following());
    stream.cyclic.stop();
    // 2^30 periods, less some.
    stream.tick += 0x80000000U - RestingStream::kPeriod * lag;
    stream.rest_at(-100000);
    stream.periods(20, false);
    stream.cyclic.start();
    stream.followed = 0;
    stream.farthest = 0.0;
    stream.periods(40, true);
    EXPECT_GT(stream.followed, 20) << "the new stream is followed";
    ASSERT_LE(stream.farthest, 2.0) << lag;
  }
}

// SYNC goes on for 2^31 periods (five days at 0.2 ms) after the last set-point, with the mode enabled: the
// segments of then are not played when their numbers come round.
TEST(CyclicPosition, AStreamThatEndedIsNotPlayedAgain) {
  RestingStream stream;
  stream.rest_at(100000);
  stream.periods(40, true);
  ASSERT_TRUE(stream.cyclic.following());
  stream.periods(10, false);
  ASSERT_FALSE(stream.cyclic.following());
  stream.rest_at(-100000);
  stream.followed = 0;
  // As few SYNCs as keep the lock: two in time make up for a silence.
  constexpr std::uint32_t kSilence = 60;
  const std::uint32_t from = stream.tick;
  const std::uint32_t round = 0U - RestingStream::kPeriod * (3 * kSilence);
  while (stream.tick - from < round) {
    for (const std::uint32_t periods : {kSilence, 1U, 1U}) {
      stream.tick += RestingStream::kPeriod * periods;
      stream.sync(false);
    }
    ASSERT_TRUE(stream.cyclic.clock().locked());
  }
  stream.periods(6 * kSilence, false);
  EXPECT_EQ(stream.followed, 0);
}

// Bridged are the set-points that were missing, and those that came when their segment had begun.
TEST(CyclicPosition, CountsWhatItHasBridged) {
  RestingStream stream;
  stream.rest_at(100000);
  // Before there is a stream nothing is bridged.
  stream.periods(20, false);
  for (const int missing : {1, 2, 4, 1}) {
    stream.periods(2, true);
    stream.periods(missing, false);
  }
  ASSERT_FALSE(stream.cyclic.following());
  stream.periods(40, true);
  std::uint32_t bridged = stream.cyclic.bridged();
  EXPECT_EQ(bridged, 0U);
  for (const int missing : {1, 2, 1, 2}) {
    stream.periods(missing, false);
    stream.periods(5, true);
    bridged += static_cast<std::uint32_t>(missing);
    EXPECT_EQ(stream.cyclic.bridged(), bridged);
  }
  // In motion it can be told which one is late: SYNC with its set-point comes with the next one.
  std::int32_t place = 100000;
  const auto moving = [&](int count) {
    for (; count > 0; --count) {
      stream.rest_at(place += 10);
      stream.periods(1, true);
    }
  };
  moving(40);
  EXPECT_EQ(stream.cyclic.bridged(), bridged);
  for (std::uint32_t i = 0; i < RestingStream::kPeriod; ++i) stream.step();
  stream.rest_at(place += 10);
  stream.sync(true);
  moving(20);
  EXPECT_EQ(stream.cyclic.bridged(), bridged + 1);
  EXPECT_EQ(stream.cyclic.gaps(), 0U);
}

// Velocities in counts per period, from a reference at rest.
struct VelocityStream {
  explicit VelocityStream(std::uint32_t period_ticks) {
    cyclic.set_period(static_cast<float>(period_ticks), 1e-4F);
    path.set_limits(
        cyclic.path_limits({250.0F, 0.5F, 0.5F, 0.005F}, PositionRange{}, CyclicPosition::kRounding));
  }
  void sync(bool has_target, float velocity) {
    cyclic.sync_velocity(tick, has_target, velocity, path, [](std::uint32_t) { return Motion{}; });
  }

  CyclicPosition cyclic;
  StreamPath path;
  std::uint32_t tick = 1000;
};

// Velocities that are lost or late now and then, played from a first period of any number: its number is in
// nothing that is played.
TEST(CyclicPosition, VelocitiesAreFollowedWhateverTheNumberOfThePeriod) {
  constexpr std::uint32_t kTicks = 4;
  const auto played = [](std::uint32_t earlier_periods) {
    VelocityStream stream(kTicks);
    CyclicPosition& cyclic = stream.cyclic;
    std::uint32_t& tick = stream.tick;
    const auto sync = [&](bool has_target, float velocity) { stream.sync(has_target, velocity); };
    // SYNC alone, rare enough to be quick and often enough to keep the lock.
    for (std::uint32_t i = 0; i < 40; ++i, tick += kTicks) sync(false, 0.0F);
    tick += kTicks * earlier_periods;
    for (std::uint32_t i = 0; i < 40; ++i, tick += kTicks) sync(false, 0.0F);
    cyclic.start();
    std::vector<double> places;
    for (std::uint32_t n = 0; n < 200; ++n) {
      const bool late = n % 17 == 11;  // by half a period: between two
      for (std::uint32_t i = 0; i < kTicks; ++i, cyclic.poll(++tick)) {
        if (i == (late ? kTicks / 2 : 0)) sync(n % 13 != 5, 20.0F * std::sin(0.05F * static_cast<float>(n)));
        if (!cyclic.step(tick)) continue;
        const StreamPoint at = cyclic.point();
        places.push_back(static_cast<double>(at.counts) + static_cast<double>(at.offset));
      }
    }
    return places;
  };
  const std::vector<double> first = played(0);
  EXPECT_GT(first.size(), 190 * kTicks);
  for (const std::uint32_t earlier : {0x20000000U, 0x3FFFFFC0U})
    EXPECT_EQ(played(earlier), first) << std::hex << earlier;
}

// A set-point that comes a little before its period, after three that never came: the stream before it is
// left while its last segment is played, and that is one gap. The tick, which finds no segment in the next
// period, counts none.
TEST(CyclicPosition, AStreamThatIsLeftIsOneGap) {
  constexpr std::uint32_t kTicks = 20;
  constexpr std::uint32_t kEarly = 3;
  VelocityStream stream(kTicks);
  CyclicPosition& cyclic = stream.cyclic;
  std::uint32_t& tick = stream.tick;
  const auto sync = [&](bool has_target) { stream.sync(has_target, 1.0F); };
  const auto steps = [&](std::uint32_t count) {
    for (; count > 0; --count) {
      cyclic.poll(++tick);
      static_cast<void>(cyclic.step(tick));
    }
  };
  const auto periods = [&](int count, bool has_target) {
    for (; count > 0; --count) {
      sync(has_target);
      steps(kTicks);
    }
  };
  cyclic.start();
  periods(40, false);
  periods(40, true);
  ASSERT_TRUE(cyclic.following());
  periods(2, false);
  sync(false);
  steps(kTicks - kEarly);
  ASSERT_TRUE(cyclic.following()) << "the last segment is not over";
  sync(true);
  EXPECT_FALSE(cyclic.following());
  EXPECT_EQ(cyclic.gaps(), 1U);
  steps(kTicks + kEarly);
  EXPECT_EQ(cyclic.gaps(), 1U) << "counted once";
  periods(10, true);
  EXPECT_TRUE(cyclic.following()) << "the next stream";
  EXPECT_EQ(cyclic.gaps(), 1U);
}

// A stream ends in one of three ways: set-points stay away, SYNC comes with another period until its lock is
// lost, or it is told to stop. The first two are gaps, one each; nothing that leads the reference is no gap.
TEST(CyclicPosition, CountsEachStreamThatEndsUnasked) {
  const auto lose_lock = [](RestingStream& stream) {
    for (int i = 0; i < 200 && stream.cyclic.clock().locked(); ++i) {
      stream.tick += RestingStream::kPeriod / 2;
      stream.sync(true);
      for (std::uint32_t tick = 0; tick < RestingStream::kPeriod; ++tick) stream.step();
    }
    ASSERT_FALSE(stream.cyclic.clock().locked());
    EXPECT_FALSE(stream.cyclic.following());
  };
  RestingStream stream;
  stream.rest_at(100000);
  stream.periods(40, true);
  ASSERT_TRUE(stream.cyclic.following());
  EXPECT_EQ(stream.cyclic.gaps(), 0U);
  lose_lock(stream);
  EXPECT_EQ(stream.cyclic.gaps(), 1U) << "the lock is lost";
  lose_lock(stream);
  EXPECT_EQ(stream.cyclic.gaps(), 1U) << "there is no stream to end";
  stream.periods(40, true);
  ASSERT_TRUE(stream.cyclic.following());
  stream.periods(10, false);
  EXPECT_EQ(stream.cyclic.gaps(), 2U) << "no set-points";
  lose_lock(stream);
  EXPECT_EQ(stream.cyclic.gaps(), 2U);
  stream.periods(40, true);
  ASSERT_TRUE(stream.cyclic.following());
  stream.cyclic.stop();
  lose_lock(stream);
  EXPECT_EQ(stream.cyclic.gaps(), 2U) << "stopped";
}

// A stream that jumps, stops and runs away: never more than the limits; and it is met. Half of the runs begin
// in a stop that is harder than the limits: its acceleration may be kept, but not turned round.
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
    float change = run % 2 == 0 ? 0.0F : uniform(-3.0, 3.0) * limits.acceleration;
    for (int tick = 0; tick < 100000; ++tick) {
      const float step = tracking_step(static_cast<float>(r - x), stream, last, change, limits);
      ASSERT_LE(std::abs(step), limits.velocity * 1.00001F);
      const float rounding = 1e-4F * limits.acceleration + 1e-5F * limits.velocity;
      ASSERT_LE(step - last, std::max(limits.acceleration, change) + rounding);
      ASSERT_GE(step - last, std::min(-limits.acceleration, change) - rounding);
      change = step - last;
      x += static_cast<double>(step);
      r += static_cast<double>(stream);
      last = step;
      if (tick > 80000) {  // 60000 to turn round, catch up and brake in the slowest
        ASSERT_LT(std::abs(r - x), 1e-2) << run;
      }
    }
  }
}

// The bound of the stopping distance against the way itself, from random velocities and accelerations.
TEST(Range, TheStoppingDistanceIsNeverTooShort) {
  std::mt19937 random(8);
  const auto uniform = [&random](double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
  };
  double longest_excess = 0.0;
  for (int run = 0; run < 3000; ++run) {
    const float deceleration = uniform(0.01, 0.3);
    const float jerk = deceleration * uniform(1e-3, 2e-2);
    const BrakingLimits limits = braking_limits(deceleration, jerk);
    const StoppingDistanceBound stopping = StoppingDistanceBound::of(deceleration, jerk);
    const float v0 = uniform(0.0, 250.0);
    const float a0 = uniform(0.0, 1.0) * deceleration;
    std::int64_t velocity = to_fixed(v0);
    std::int64_t acceleration = to_fixed(a0);
    double way = 0.0;
    for (int tick = 0; tick < 400000 && (velocity != 0 || acceleration != 0); ++tick) {
      acceleration = braking_acceleration(velocity, acceleration, limits);
      velocity += acceleration;
      way += static_cast<double>(velocity) * 0x1p-44;
    }
    const auto bound = static_cast<double>(stopping.from(v0, a0));
    // A tick's way for the discrete time.
    EXPECT_LE(way, bound + static_cast<double>(v0) + 1.0) << run << ' ' << v0 << ' ' << a0;
    longest_excess = std::max(longest_excess, (bound - way) / (way + 1000.0));
  }
  EXPECT_LT(longest_excess, 1.5) << "and not longer than needed, where it matters";
}

// The signed stopping distance, also where the acceleration turns the motion round before it is taken out.
TEST(Range, TheStoppingDistanceIsTheWayThatAStopTakes) {
  std::mt19937 random(9);
  const auto uniform = [&random](double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
  };
  int turned = 0;
  for (int run = 0; run < 3000; ++run) {
    const float deceleration = uniform(0.01, 0.3);
    const float jerk = deceleration * uniform(1e-3, 2e-2);
    const BrakingLimits limits = braking_limits(deceleration, jerk);
    const float v0 = uniform(-1.0, 1.0) * (run % 2 == 0 ? 250.0F : deceleration * deceleration / jerk);
    const float a0 = uniform(-1.0, 1.0) * deceleration;
    std::int64_t velocity = to_fixed(v0);
    std::int64_t acceleration = to_fixed(a0);
    double way = 0.0, largest = static_cast<double>(std::abs(v0));
    for (int tick = 0; tick < 400000 && (velocity != 0 || acceleration != 0); ++tick) {
      acceleration = braking_acceleration(velocity, acceleration, limits);
      velocity += acceleration;
      way += static_cast<double>(velocity) * 0x1p-44;
      largest = std::max(largest, std::abs(static_cast<double>(velocity) * 0x1p-44));
    }
    const auto told = static_cast<double>(StoppingDistance(deceleration, jerk)(v0, a0));
    // Some ticks for the discrete time.
    EXPECT_NEAR(told, way, 0.004 * std::abs(way) + 4.0 * largest + 0.5) << run << ' ' << v0 << ' ' << a0;
    const float left = v0 + 0.5F * a0 * std::abs(a0) / jerk;
    turned += v0 * left < 0.0F && std::abs(told) > 10.0 * largest ? 1 : 0;
  }
  EXPECT_GT(turned, 100);
}

TEST(Range, AnEndThatIsTheLastCountDoesNotBound) {
  const PositionRange all;
  EXPECT_GT(all.room(2147483600, true), 1e9F);
  EXPECT_GT(all.room(-2147483600, false), 1e9F);
  const PositionRange some{-2000000000, 2000000000};
  EXPECT_FLOAT_EQ(some.room(-2000000000, true), 4e9F);
  EXPECT_EQ(some.room(2000000001, true), 0.0F);
  EXPECT_EQ(some.nearest(std::int64_t{1} << 40), 2000000000);
  EXPECT_EQ(all.nearest(std::int64_t{1} << 40), std::int64_t{1} << 40)
      << "no such count: for others to refuse";
}

}  // namespace
}  // namespace slipstack
