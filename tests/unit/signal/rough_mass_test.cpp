// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/rough_mass.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/draw.h"

namespace slipstack::workbench {
namespace {

constexpr double kMass_kg = 3.0;

struct Recorded {
  std::vector<double> position_m;
  std::vector<double> force_N;
};

/// A log that is cut out of a motion: it begins and ends at speed.
Recorded cut_out_of_motion(double rate_Hz, double step_m) {
  slipstack::test::Draw draw(5);
  Recorded log;
  for (std::size_t i = 0; i < static_cast<std::size_t>(8.0 * rate_Hz); ++i) {
    const double t = static_cast<double>(i) / rate_Hz + 0.3;
    const double x = 0.2 * std::sin(1.7 * t) + 0.03 * std::sin(6.1 * t);
    const double v = 0.34 * std::cos(1.7 * t) + 0.183 * std::cos(6.1 * t);
    const double a = -0.578 * std::sin(1.7 * t) - 1.1163 * std::sin(6.1 * t);
    log.position_m.push_back(step_m > 0.0 ? step_m * std::round(x / step_m) : x);
    log.force_N.push_back(kMass_kg * a + 4.0 * v + std::copysign(2.0, v) + 0.02 * draw.normal());
  }
  return log;
}

// At the ends of the log the smoothed position stands still, which is no acceleration of the axis: it would
// be thousands of times that of the motion, and the mass nothing.
TEST(RoughMass, OfALogThatIsCutOutOfAMotion) {
  for (const double rate_Hz : {500.0, 8000.0}) {
    const Recorded log = cut_out_of_motion(rate_Hz, 0.0);
    EXPECT_NEAR(rough_mass_kg(log.position_m, log.force_N, rate_Hz, 0.0, {}), kMass_kg, 0.05 * kMass_kg)
        << rate_Hz;
  }
}

// The steps of a coarse encoder at a high rate are accelerations that no force belongs to.
TEST(RoughMass, OfACoarseEncoder) {
  constexpr double kRate_Hz = 8000.0;
  constexpr double kStep_m = 1e-4;
  const Recorded log = cut_out_of_motion(kRate_Hz, kStep_m);
  const double known_kg = rough_mass_kg(log.position_m, log.force_N, kRate_Hz, kStep_m, {});
  const double unknown_kg = rough_mass_kg(log.position_m, log.force_N, kRate_Hz, 0.0, {});
  EXPECT_NEAR(known_kg, kMass_kg, 0.1 * kMass_kg);
  EXPECT_LT(unknown_kg, 0.5 * kMass_kg) << "the encoder of this test is not coarse";
}

}  // namespace
}  // namespace slipstack::workbench
