// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "sim_host/log/draw.h"
#include "sim_host/motion/programme.h"

namespace slipstack::sim {
namespace {

// Velocity and acceleration are the derivatives of position and velocity; ends are at rest.
void expect_consistent(const Segment& segment, double from_m, double to_m) {
  const double duration = segment.duration_s();
  EXPECT_NEAR(segment.at(0.0).x_m, from_m, 1e-14);
  EXPECT_NEAR(segment.at(duration).x_m, to_m, 1e-12);
  for (const double end : {0.0, duration}) {
    EXPECT_NEAR(segment.at(end).v_mps, 0.0, 1e-9);
    EXPECT_NEAR(segment.at(end).a_mps2, 0.0, 1e-7);
  }
  const double h = duration * 1e-6;
  for (int i = 1; i < 500; ++i) {
    const double t = duration * i / 500.0 + 0.3 * h;
    const MotionPoint before = segment.at(t - h);
    const MotionPoint now = segment.at(t);
    const MotionPoint after = segment.at(t + h);
    const double v_scale = std::fabs(to_m - from_m) / duration + std::fabs(now.v_mps) + 1e-6;
    const double a_scale = v_scale / duration + std::fabs(now.a_mps2) + 1e-3;
    ASSERT_NEAR((after.x_m - before.x_m) / (2.0 * h), now.v_mps, 1e-4 * v_scale);
    ASSERT_NEAR((after.v_mps - before.v_mps) / (2.0 * h), now.a_mps2, 1e-3 * a_scale);
  }
}

TEST(Segment, JerkLimitedMovesKeepTheirLimitsAndArrive) {
  Rng rng(1);
  for (int trial = 0; trial < 300; ++trial) {
    const MoveLimits limits = {rng.log_uniform(1e-3, 2.0), rng.log_uniform(0.1, 20.0),
                               rng.log_uniform(5.0, 3000.0)};
    const double from = rng.uniform(0.0, 0.5);
    const double to = from + (rng.chance(0.5) ? 1.0 : -1.0) * rng.log_uniform(1e-6, 0.5);
    const auto move = make_jerk_limited_move(from, to, limits);
    const double duration = move->duration_s();
    double fastest = 0.0;
    for (int i = 0; i <= 400; ++i) {
      const MotionPoint point = move->at(duration * i / 400.0);
      fastest = std::max(fastest, std::fabs(point.v_mps));
      ASSERT_LE(std::fabs(point.v_mps), limits.velocity_mps * (1.0 + 1e-9));
      ASSERT_LE(std::fabs(point.a_mps2), limits.acceleration_mps2 * (1.0 + 1e-9));
    }
    // No slower than the cautious plan that reaches its peak with full ramps; no faster than the velocity
    // allows.
    ASSERT_GE(duration, std::fabs(to - from) / limits.velocity_mps * (1.0 - 1e-12));
    ASSERT_GT(fastest, 0.0);
    expect_consistent(*move, from, to);
  }
}

TEST(Segment, LongMoveTakesTheTextbookTime) {
  // Full ramps and a cruise: T = d/v + v/a + a/j.
  const auto move = make_jerk_limited_move(0.0, 1.0, {0.5, 5.0, 100.0});
  EXPECT_NEAR(move->duration_s(), 1.0 / 0.5 + 0.5 / 5.0 + 5.0 / 100.0, 1e-12);
  // Never cruising nor holding: four phases of full jerk, T = 4·(d/2j)^⅓.
  const auto dart = make_jerk_limited_move(0.0, 1e-3, {0.5, 50.0, 100.0});
  EXPECT_NEAR(dart->duration_s(), 4.0 * std::cbrt(1e-3 / 200.0), 1e-12);
}

TEST(Segment, QuinticAndSineAreSmooth) {
  expect_consistent(*make_quintic_move(0.1, 0.25, 0.2), 0.1, 0.25);
  EXPECT_NEAR(make_quintic_move(0.0, 0.1, 0.2)->at(0.5 * 1.875 * 0.1 / 0.2).v_mps, 0.2, 1e-12);
  expect_consistent(*make_sine(0.1, 30e-6, 3.0, 4), 0.1, 0.1);
  EXPECT_NEAR(make_sine(0.0, 30e-6, 1.0, 3)->at(1.25).x_m, 30e-6, 1e-18);
}

TEST(Segment, RefusesWhatCannotMove) {
  EXPECT_THROW(make_jerk_limited_move(0.0, 1.0, {0.0, 1.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(make_quintic_move(0.0, 1.0, -1.0), std::invalid_argument);
  EXPECT_THROW(make_sine(0.0, 1.0, 0.0, 3), std::invalid_argument);
  EXPECT_THROW(make_dwell(0.0, -1.0), std::invalid_argument);
}

TEST(Programme, StaysOnTheRailAndHoldsTogether) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Bench bench = draw_bench(Setup::kRandom, seed);
    const MotionProgramme programme = draw_programme(bench, seed);
    EXPECT_GE(programme.duration_s(), bench.programme.seconds) << seed;
    EXPECT_LE(programme.duration_s(), 1.03 * bench.programme.seconds) << seed;
    MotionPoint last = programme.at(0.0);
    double fastest = 0.0;
    double slow_s = 0.0;
    constexpr double kStep = 2e-4;
    for (double t = kStep; t < programme.duration_s(); t += kStep) {
      const MotionPoint now = programme.at(t);
      ASSERT_GE(now.x_m, 0.0);
      ASSERT_LE(now.x_m, bench.axis.stroke_m);
      // Continuous: what the velocity explains, and no more than 1 m/s per 0.01 s change of it.
      ASSERT_NEAR(now.x_m - last.x_m, 0.5 * (now.v_mps + last.v_mps) * kStep, 2e-7) << seed << " at " << t;
      ASSERT_NEAR(now.v_mps, last.v_mps, 100.0 * kStep);
      fastest = std::max(fastest, std::fabs(now.v_mps));
      if (std::fabs(now.v_mps) > 1e-3 && std::fabs(now.v_mps) < 1e-2) slow_s += kStep;
      last = now;
    }
    EXPECT_GT(fastest, 0.1);
    EXPECT_GT(slow_s, 2.0) << "no slow traverses";
  }
}

TEST(Programme, RefusesToBeTooShort) {
  Bench bench = draw_bench(Setup::kPickAndPlace, 1);
  Rng rng(1);
  EXPECT_THROW(make_test_programme(bench.axis, {7.0, 0.0, 0.0}, rng), std::invalid_argument);
}

}  // namespace
}  // namespace slipstack::sim
