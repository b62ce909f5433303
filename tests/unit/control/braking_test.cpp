// SPDX-License-Identifier: Apache-2.0
// The stopping distance: from any state, within deceleration and jerk, in the time of the continuous optimum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "firmware/control/reference/braking.h"
#include "firmware/control/reference/motion.h"

namespace slipstack {
namespace {

constexpr double kUnit = 0x1p-44;

double real(std::int64_t fixed) {
  return static_cast<double>(fixed) * kUnit;
}

struct State {
  double velocity, acceleration;
};

struct Optimum {
  double ticks, counts;
};

// Shortest stopping distance in continuous time; jerk, hold, jerk.
Optimum optimum(State s, double deceleration, double jerk) {
  const double free = s.velocity + s.acceleration * std::abs(s.acceleration) / (2.0 * jerk);
  const double sign = free > 0.0 ? 1.0 : -1.0;
  double v = sign * s.velocity;
  double a = sign * s.acceleration;
  double x = 0.0;
  double ticks = 0.0;
  const auto go = [&](double j, double t) {
    x += t * (v + t * (0.5 * a + t * j / 6.0));
    v += t * (a + 0.5 * t * j);
    a += t * j;
    ticks += t;
  };
  const double peak = std::sqrt(jerk * v + 0.5 * a * a);
  if (a < -deceleration) {
    go(jerk, (-deceleration - a) / jerk);
  } else {
    go(-jerk, (a + std::min(peak, deceleration)) / jerk);
  }
  if (peak > deceleration) go(0.0, (v - 0.5 * a * a / jerk) / -a);
  go(jerk, -a / jerk);
  return {ticks, sign * x};
}

struct Played {
  int ticks = 0;
  double counts = 0.0, largest_jerk = 0.0, largest_acceleration = 0.0, largest_velocity = 0.0;
};

Played play(std::int64_t velocity, std::int64_t acceleration, const BrakingLimits& limits, int longest) {
  Played played;
  while ((velocity != 0 || acceleration != 0) && played.ticks < longest) {
    const std::int64_t next = braking_acceleration(velocity, acceleration, limits);
    played.largest_jerk = std::max(played.largest_jerk, std::abs(real(next - acceleration)));
    played.largest_acceleration = std::max(played.largest_acceleration, std::abs(real(next)));
    acceleration = next;
    velocity += acceleration;
    played.largest_velocity = std::max(played.largest_velocity, std::abs(real(velocity)));
    played.counts += real(velocity);
    ++played.ticks;
  }
  return played;
}

class LogUniform {
 public:
  explicit LogUniform(unsigned seed) : random_(seed) {}
  double operator()(double low, double high) {
    return std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(random_));
  }
  double sign() { return random_() % 2 == 0 ? 1.0 : -1.0; }

 private:
  std::mt19937 random_;
};

TEST(Braking, EndsAtRestWithinItsLimitsInTheShortestTime) {
  LogUniform random(17);
  double slowest = 0.0, farthest = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double deceleration = random(1e-3, 1e3);
    const double jerk = deceleration / random(1.0, 1e3);
    const double velocity = random.sign() * std::min(random(1e-6, 1e4) * deceleration, 2.6e5);
    const double acceleration = random.sign() * random(1e-6, 1.0) * deceleration * (i % 10 == 0 ? 3.0 : 1.0);
    const BrakingLimits limits = braking_limits(static_cast<float>(deceleration), static_cast<float>(jerk));
    const std::int64_t v0 = to_fixed(static_cast<float>(velocity));
    const std::int64_t a0 = to_fixed(static_cast<float>(acceleration));
    // A step of the sums is the mean velocity of a tick: half an increment earlier it is that of an instant.
    const Optimum best = optimum({real(v0) - 0.5 * real(a0), real(a0)}, deceleration, jerk);
    const int longest = static_cast<int>(1.01 * best.ticks) + 10;
    const Played played = play(v0, a0, limits, longest);
    ASSERT_LT(played.ticks, longest) << i;
    ASSERT_LE(played.largest_jerk, jerk * 1.000001 + 2 * kUnit) << i;
    ASSERT_LE(played.largest_acceleration, std::max(deceleration, std::abs(real(a0))) * 1.000001 + kUnit)
        << i;
    ASSERT_GE(played.ticks, best.ticks * 0.99999 - 1.5) << i;
    slowest = std::max(slowest, played.ticks - best.ticks * 1.001);
    // A sum against an integral: a tick of the highest velocity, and what the curve keeps in reserve.
    const double slack =
        (played.largest_velocity + std::abs(real(v0)) + std::abs(real(a0))) * (1.0 + 0.003 * best.ticks);
    farthest = std::max(farthest, std::abs(played.counts - best.counts) / slack);
  }
  EXPECT_LT(slowest, 4.0);
  EXPECT_GT(slowest, 0.5);  // whole ticks
  EXPECT_LT(farthest, 1.0);
  EXPECT_GT(farthest, 0.2);
}

// 35 kg at 2 m/s on an encoder of 1 nm, 10 kHz: the numbers of the largest axis.
// A stream that ends while it accelerates: the stop keeps below the largest velocity by giving up no more of
// the acceleration than it must, and nothing where the axis slows down.
TEST(Braking, AStopOfAStreamGivesUpWhatLeadsBeyondTheLargestVelocity) {
  std::mt19937 random(8);
  const auto uniform = [&random](double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
  };
  int given_up = 0, kept = 0;
  for (int run = 0; run < 5000; ++run) {
    const float fastest = uniform(20.0, 250.0);
    const float deceleration = fastest * uniform(0.001, 0.02);
    const BrakingLimits limits = braking_limits(deceleration, deceleration * uniform(0.005, 0.1));
    const float sign = run % 2 == 0 ? 1.0F : -1.0F;
    Motion motion;
    motion.phase = Motion::Phase::kTracking;
    motion.velocity = to_fixed(sign * fastest * uniform(run % 3 == 0 ? 0.3 : 0.97, 0.999));
    motion.acceleration = to_fixed(sign * deceleration * uniform(-1.0, 1.0));
    const std::int64_t before = motion.acceleration;
    const std::int64_t slower = motion.velocity;
    motion.leave_stream(limits, fastest);
    ASSERT_EQ(motion.velocity, slower);
    ASSERT_LE(std::abs(motion.acceleration), std::abs(before));
    ASSERT_GE(real(motion.acceleration) * real(before), 0.0) << "not turned round";
    double largest = 0.0;
    std::int64_t velocity = motion.velocity, acceleration = motion.acceleration;
    for (int tick = 0; tick < 10000 && velocity != 0; ++tick) {
      acceleration = braking_acceleration(velocity, acceleration, limits);
      velocity += acceleration;
      largest = std::max(largest, std::abs(real(velocity)));
    }
    ASSERT_LE(largest, static_cast<double>(fastest) * 1.0005) << run;
    if (motion.acceleration == before) {
      ++kept;
      continue;
    }
    ++given_up;
    ASSERT_GT(real(before) * static_cast<double>(sign), 0.0) << "it slowed down";
    // Within a jerk of a tick, and the 4096th of the acceleration.
    const double room = static_cast<double>(fastest) - std::abs(real(slower));
    const double rest = static_cast<double>(fastest) - largest;
    ASSERT_LE(rest, 0.05 * room + 2.0 * real(limits.jerk) + 1e-3 * room) << run;
  }
  EXPECT_GT(given_up, 500);
  EXPECT_GT(kept, 2000);
}

// Deceleration and jerk of the fixed point are those asked for, rounded up: never less, and never none.
TEST(Braking, LimitsAreRoundedUp) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> exponent(-20.0, 5.0);
  for (int run = 0; run < 10000; ++run) {
    const auto deceleration = static_cast<float>(std::pow(10.0, exponent(random)));
    const auto jerk = static_cast<float>(std::pow(10.0, exponent(random)));
    const BrakingLimits limits = braking_limits(deceleration, jerk);
    ASSERT_GE(limits.deceleration, 1) << deceleration;
    ASSERT_GE(limits.jerk, 1) << jerk;
    ASSERT_GE(real(limits.deceleration), static_cast<double>(deceleration));
    ASSERT_LE(real(limits.deceleration), static_cast<double>(deceleration) + kUnit);
    ASSERT_GE(real(limits.jerk), static_cast<double>(jerk));
    ASSERT_LE(real(limits.jerk), static_cast<double>(jerk) + kUnit);
  }
}

TEST(Braking, StopsTwoMetresPerSecondOnANanometreEncoder) {
  const BrakingLimits limits = braking_limits(150.0F, 1.5F);
  const Played played = play(to_fixed(2.0e5F), 0, limits, 100000);
  EXPECT_NEAR(played.ticks, 2.0e5 / 150.0 + 100.0, 3.0);
  EXPECT_NEAR(played.counts * 1e-9, 0.5 * 2.0 * (2.0 / 15.0 + 0.01), 2.5e-4);
  EXPECT_LE(played.largest_jerk, 1.5000001);
  EXPECT_GT(played.largest_jerk, 1.49);
}

// Rounding takes the motion off its curve by less than what the curve keeps in reserve: no return, no
// ringing.
TEST(Braking, DoesNotTurnBack) {
  LogUniform random(5);
  for (int i = 0; i < 2000; ++i) {
    const double jerk = random(1e-4, 1.0);
    const BrakingLimits limits =
        braking_limits(static_cast<float>(jerk * random(1.0, 500.0)), static_cast<float>(jerk));
    std::int64_t velocity = to_fixed(static_cast<float>(std::min(random(1.0, 1e6) * jerk, 2.6e5)));
    std::int64_t acceleration = 0;
    int ticks = 0;
    while ((velocity != 0 || acceleration != 0) && ++ticks < 10000000) {
      const std::int64_t before = velocity;
      acceleration = braking_acceleration(velocity, acceleration, limits);
      velocity += acceleration;
      ASSERT_GE(real(velocity), -0.01 * jerk) << i;
      ASSERT_LE(real(velocity - before), 0.01 * jerk) << i;
    }
  }
}

}  // namespace
}  // namespace slipstack
