// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "workbench/plan/segments.h"

namespace slipstack::workbench {
namespace {

AxisLimits random_limits(std::mt19937_64& random) {
  const auto log_uniform = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0.0, 1.0)(random));
  };
  AxisLimits limits;
  limits.low_m = log_uniform(0.01, 1.0) - 0.3;
  limits.high_m = limits.low_m + log_uniform(0.02, 2.0);
  limits.velocity_mps = log_uniform(0.01, 3.0);
  limits.acceleration_mps2 = log_uniform(0.1, 30.0);
  limits.jerk_mps3 = limits.acceleration_mps2 * log_uniform(5.0, 200.0);
  return limits;
}

/// Positions follow from velocities, and velocities from accelerations, to the order of the sampling.
void expect_consistent(const SetPoints& points, const AxisLimits& limits) {
  const double step_s = 1.0 / points.rate_Hz;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double moved_m = 0.5 * step_s * (points.velocity_mps[i] + points.velocity_mps[i - 1]);
    EXPECT_NEAR(points.position_m[i] - points.position_m[i - 1], moved_m,
                limits.jerk_mps3 * step_s * step_s * step_s + 1e-12);
    const double faster_mps = 0.5 * step_s * (points.acceleration_mps2[i] + points.acceleration_mps2[i - 1]);
    EXPECT_NEAR(points.velocity_mps[i] - points.velocity_mps[i - 1], faster_mps,
                limits.jerk_mps3 * step_s * step_s + 1e-12);
  }
}

TEST(Segments, StayWithinTheLimitsAndReturnToRest) {
  std::mt19937_64 random(7);
  std::size_t seen = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const AxisLimits limits = random_limits(random);
    for (const MotionSegment& segment : possible_segments(limits, 20e-6)) {
      MotionBuilder builder(1000.0, segment.start_m);
      segment.append(builder);
      builder.dwell(0.01);
      const AxisLimits found = extremes_of(builder.points());
      EXPECT_GE(found.low_m, limits.low_m) << segment.name;
      EXPECT_LE(found.high_m, limits.high_m) << segment.name;
      EXPECT_LE(found.velocity_mps, limits.velocity_mps) << segment.name;
      EXPECT_LE(found.acceleration_mps2, limits.acceleration_mps2) << segment.name;
      EXPECT_LE(found.jerk_mps3, 1.02 * limits.jerk_mps3) << segment.name;  // by differences of samples
      EXPECT_EQ(builder.points().velocity_mps.back(), 0.0);
      EXPECT_NEAR(builder.position_m(), segment.start_m, 1e-5 * limits.stroke_m() + 1e-7) << segment.name;
      expect_consistent(builder.points(), limits);
      ++seen;
    }
  }
  EXPECT_GT(seen, 100u);
}

TEST(MotionBuilder, MovesExactlyToThePlace) {
  AxisLimits limits{0.0, 1.0, 0.5, 4.0, 100.0, 0.0};
  MotionBuilder builder(1000.0, 0.1);
  builder.move_to(0.9, limits);
  builder.dwell(0.1);
  EXPECT_NEAR(builder.points().position_m.back(), 0.9, 1e-12);
  const AxisLimits found = extremes_of(builder.points());
  EXPECT_GT(found.velocity_mps, 0.75 * limits.velocity_mps);  // and no slower than necessary
}

}  // namespace
}  // namespace slipstack::workbench
