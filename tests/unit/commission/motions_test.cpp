// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/motions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim_host/rng.h"

namespace slipstack::workbench {
namespace {

// Every motion of a commissioning stays within the room and its limits, whatever the axis.
TEST(CommissionMotions, StayWithinTheirLimits) {
  sim::Rng rng(7, "motions");
  for (int i = 0; i < 60; ++i) {
    Nameplate plate;
    plate.encoder_resolution_m = rng.pick({1e-8, 1e-7, 1e-6, 5e-6});
    plate.motor_constant_N_per_A = 60.0;
    plate.travel_m = rng.log_uniform(0.06, 1.0);
    plate.largest_velocity_mps = rng.log_uniform(0.2, 3.0);
    const double mass_kg = rng.log_uniform(0.5, 80.0);
    const double friction_N = rng.log_uniform(0.5, 30.0);
    plate.current_limit_A = (rng.log_uniform(10.0, 40.0) * mass_kg + 4.0 * friction_N) / 60.0;
    const AxisLimits limits = first_limits(plate, mass_kg, friction_N);
    EXPECT_LT(mass_kg * limits.acceleration_mps2 + friction_N, 0.75 * plate.force_limit_N());
    EXPECT_GE(limits.low_m, 0.04 * plate.travel_m);
    EXPECT_LE(limits.high_m, 0.96 * plate.travel_m);
    std::vector<SetPoints> motions{holding_motion(limits), travel_motion(limits),
                                   tracking_test(limits).motion};
    for (const double pace : {0.4, 1.0})
      motions.push_back(first_look(limits, pace, plate.encoder_resolution_m));
    for (const SetPoints& motion : motions) {
      const AxisLimits reached = extremes_of(motion);
      EXPECT_GE(reached.low_m, limits.low_m - 1e-9) << i;
      EXPECT_LE(reached.high_m, limits.high_m + 1e-9) << i;
      EXPECT_LE(reached.velocity_mps, 1.001 * limits.velocity_mps) << i;
      EXPECT_LE(reached.acceleration_mps2, 1.001 * std::max(limits.acceleration_mps2, 0.2)) << i;
      EXPECT_LT(motion.duration_s(), 50.0) << i;
      EXPECT_GT(motion.duration_s(), 1.0) << i;
    }
  }
}

TEST(CommissionMotions, TheTravelIsSeenFromEndToEnd) {
  Nameplate plate{1e-6, 60.0, 10.0, 0.4, 1.0, {}, 1e-4};
  const AxisLimits limits = first_limits(plate, 35.0, 15.0);
  const AxisLimits reached = extremes_of(travel_motion(limits));
  EXPECT_NEAR(reached.low_m, 0.02, 1e-6);
  EXPECT_NEAR(reached.high_m, 0.38, 1e-6);
  EXPECT_LE(reached.velocity_mps, 0.2);
}

TEST(CommissionMotions, TheTestRepeatsItsCycle) {
  const Nameplate plate{1e-6, 60.0, 10.0, 0.4, 1.0, {}, 1e-4};
  const TrackingTest test = tracking_test(first_limits(plate, 35.0, 15.0));
  ASSERT_EQ(test.motion.size(), TrackingTest::kCycles * test.cycle_points);
  for (std::size_t i = 0; i < test.cycle_points; ++i) {
    ASSERT_NEAR(test.motion.position_m[i], test.motion.position_m[i + 3 * test.cycle_points], 1e-9) << i;
  }
}

}  // namespace
}  // namespace slipstack::workbench
