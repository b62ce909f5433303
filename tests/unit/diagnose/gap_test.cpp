// SPDX-License-Identifier: Apache-2.0
// A carriage behind a gap: free flight and impact as mechanics gives them, and the momentum that no impact
// loses.
#include "workbench/diagnose/alternatives/gap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace slipstack::workbench {
namespace {

constexpr double kTick_s = 1e-4;
constexpr double kGap_m = 50e-6;
constexpr double kDeceleration_mps2 = 2.0;
constexpr double kSlip_m = 5e-6;

Sample<double> sample_at(double position_m, double velocity_mps, double acceleration_mps2) {
  Sample<double> sample;
  sample.position_m = position_m;
  sample.velocity_mps = velocity_mps;
  sample.acceleration_mps2 = acceleration_mps2;
  return sample;
}

/// A motor that pushes steadily, so that the friction has developed, and from t = 0 on brakes by 12 m/s2.
Sample<double> braking_at(double t_s) {
  constexpr double kSpeed_mps = 0.2;
  constexpr double kBrake_mps2 = 12.0;
  if (t_s <= 0.0) return sample_at(kSpeed_mps * t_s, kSpeed_mps, 0.0);
  return sample_at(kSpeed_mps * t_s - 0.5 * kBrake_mps2 * t_s * t_s, kSpeed_mps - kBrake_mps2 * t_s,
                   -kBrake_mps2);
}

TEST(GapInDrive, FliesAcrossTheGapAndHitsTheOtherFlank) {
  GapInDrive drive({kGap_m, kDeceleration_mps2, kSlip_m}, kTick_s);
  drive.reset(braking_at(-0.05));
  // The carriage decelerates by its friction and the motor by 12 m/s2: they close 10 m/s2.
  const double flight_s = std::sqrt(2.0 * kGap_m / 10.0);
  double impulse_mps = 0.0;
  for (int i = -500; i <= 120; ++i) {
    const double t_s = i * kTick_s;
    const double missing = drive.step(braking_at(t_s));
    const double rigid = t_s > 0.0 ? -12.0 + kDeceleration_mps2 : kDeceleration_mps2;
    if (t_s > -0.01 && t_s <= 0.0) {
      EXPECT_NEAR(missing, 0.0, 1e-9) << t_s;  // pushed, as without a gap
    }
    if (t_s > 2.0 * kTick_s && t_s < flight_s - 3.0 * kTick_s) {
      EXPECT_NEAR(missing, -rigid, 1e-9) << t_s;  // no force at all
    }
    if (std::abs(t_s - flight_s) <= 3.0 * kTick_s) impulse_mps += (missing + rigid) * kTick_s;
    if (t_s > flight_s + 4.0 * kTick_s && t_s < 0.012) {
      EXPECT_NEAR(missing, 0.0, 1e-9) << t_s;  // the other flank brakes it
    }
  }
  // The carriage is faster than the motor by what that lost: to a few samples of braking.
  EXPECT_NEAR(impulse_mps, -10.0 * flight_s, 4.0 * 12.0 * kTick_s);
}

// What the gap takes from the force it gives back: over whole periods of a motion the momentum of the
// carriage and what its friction took are those of a carriage without a gap.
TEST(GapInDrive, NeitherMakesNorLosesMomentum) {
  for (const double gap_m : {10e-6, 50e-6, 300e-6}) {
    GapInDrive drive({gap_m, kDeceleration_mps2, kSlip_m}, kTick_s);
    drive.reset(sample_at(0.0, 0.01 * 4.0 * M_PI, 0.0));
    double sum_mps = 0.0;
    for (int i = 0; i < 50'000; ++i) {
      const double phase = 2.0 * M_PI * 2.0 * i * kTick_s;  // 2 Hz, ten periods
      const double missing = drive.step(sample_at(0.01 * std::sin(phase), 0.01 * 4.0 * M_PI * std::cos(phase),
                                                  -0.01 * 16.0 * M_PI * M_PI * std::sin(phase)));
      if (i >= 5000) sum_mps += missing * kTick_s;
    }
    // Nine periods of friction alone would be 9 s times 2 m/s2 in either direction.
    EXPECT_NEAR(sum_mps, 0.0, 0.05) << gap_m;
  }
}

// A gap that is far smaller than any motion of a sample changes nothing.
TEST(GapInDrive, WithoutWidthIsARigidDrive) {
  GapInDrive drive({1e-12, kDeceleration_mps2, kSlip_m}, kTick_s);
  drive.reset(sample_at(0.0, 0.01 * 4.0 * M_PI, 0.0));
  double sum = 0.0;
  double rigid = 0.0;
  for (int i = 0; i < 20'000; ++i) {
    const double phase = 2.0 * M_PI * 2.0 * i * kTick_s;
    const double acceleration_mps2 = -0.01 * 16.0 * M_PI * M_PI * std::sin(phase);
    const double missing =
        drive.step(sample_at(0.01 * std::sin(phase), 0.01 * 4.0 * M_PI * std::cos(phase), acceleration_mps2));
    sum += missing * missing;
    rigid += acceleration_mps2 * acceleration_mps2;
  }
  EXPECT_LT(sum, 0.02 * rigid);
}

}  // namespace
}  // namespace slipstack::workbench
