// SPDX-License-Identifier: Apache-2.0
// When the force that a drive transmits changes its sign: as mechanics gives it.
#include "workbench/diagnose/alternatives/load_reversals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slipstack::workbench {
namespace {

constexpr double kTickOfLoad_s = 1e-3;
constexpr double kFriction_mps2 = 2.0;
constexpr double kSlipOfLoad_m = 10e-6;

/// The load after one second at 0.2 m/s and braking for `seconds`.
LoadReversals after_braking(double brake_mps2, double seconds) {
  LoadReversals load({kFriction_mps2, kSlipOfLoad_m}, kTickOfLoad_s);
  load.reset({});
  const auto ticks = static_cast<int>(std::lround((1.0 + seconds) / kTickOfLoad_s));
  for (int i = 0; i < ticks; ++i) {
    const double braking_s = std::max(0.0, i * kTickOfLoad_s - 1.0);
    Sample<double> sample;
    sample.velocity_mps = 0.2 - brake_mps2 * braking_s;
    sample.position_m = 0.2 * i * kTickOfLoad_s - 0.5 * brake_mps2 * braking_s * braking_s;
    sample.acceleration_mps2 = braking_s > 0.0 ? -brake_mps2 : 0.0;
    load.step(sample);
  }
  return load;
}

TEST(LoadReversals, ADriveThatBrakesByMoreThanTheFrictionTurnsTheLoad) {
  const LoadReversals load = after_braking(3.0, 0.05);
  EXPECT_EQ(load.side(), -1.0);
  EXPECT_NEAR(load.load(), 1.0 - 3.0 / kFriction_mps2, 1e-12);
  EXPECT_NEAR(load.since_s(), 0.05, 2.0 * kTickOfLoad_s);
}

TEST(LoadReversals, FrictionThatBrakesAloneDoesNot) {
  const LoadReversals load = after_braking(1.0, 0.05);
  EXPECT_EQ(load.side(), 1.0);
  EXPECT_GT(load.since_s(), 1e6);
}

// At rest in the middle of the hysteresis only noise is left of the load.
TEST(LoadReversals, NoiseAtStandstillIsNone) {
  LoadReversals load({kFriction_mps2, kSlipOfLoad_m}, kTickOfLoad_s);
  load.reset({});
  for (int i = 0; i < 1000; ++i) {
    Sample<double> sample;
    sample.acceleration_mps2 = 0.09 * kFriction_mps2 * (i % 2 == 0 ? 1.0 : -1.0);
    load.step(sample);
  }
  EXPECT_EQ(load.side(), 0.0);
  EXPECT_GT(load.since_s(), 1e6);
}

}  // namespace
}  // namespace slipstack::workbench
