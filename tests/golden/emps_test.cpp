// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/golden/shared_data.h"

// EMPS [5]: a real axis, with the parameters and errors that its authors published.
namespace slipstack::workbench {
namespace {

constexpr double kPublishedError = 0.0408;
constexpr double kPublishedErrorByDirection = 0.0311;

TEST(Emps, DirectionAsymmetryIsNamedAndLowersTheError) {
  const auto path = shared_file("emps/emps_estimation.csv");
  SKIP_WITHOUT(path);
  const Measurement measurement = measured(path);
  const Diagnosis diagnosis =
      diagnose(measurement,
               {.baseline = {"inertia", "coulomb", "viscous", "offset_force"}, .start = {}, .progress = {}});
  EXPECT_EQ(diagnosis.verdict, Verdict::missing_effect);
  ASSERT_EQ(diagnosis.candidates.front().term.id(), "direction_asymmetry");
  EXPECT_NEAR(diagnosis.baseline.relative_error, kPublishedError, 0.001);
  EXPECT_LT(diagnosis.best.relative_error, kPublishedErrorByDirection);
  EXPECT_GT(diagnosis.best.relative_error, 0.02);
  EXPECT_LT(diagnosis.best.holdout_rmse_N, 0.8 * diagnosis.baseline.holdout_rmse_N);
}

TEST(Emps, BaselineParametersAreThePublishedOnes) {
  const auto path = shared_file("emps/emps_estimation.csv");
  SKIP_WITHOUT(path);
  const FittedModel fitted =
      fit_effects(measured(path), {"inertia", "coulomb", "viscous", "offset_force"}, {});
  EXPECT_NEAR(find_term(fitted.terms, "inertia")->gains[0], 95.11, 0.3);
  EXPECT_NEAR(find_term(fitted.terms, "viscous")->gains[0], 203.5, 3.0);
  EXPECT_NEAR(find_term(fitted.terms, "coulomb")->gains[0], 20.39, 0.3);
  EXPECT_NEAR(find_term(fitted.terms, "offset_force")->gains[0], -3.16, 0.3);
}

}  // namespace
}  // namespace slipstack::workbench
