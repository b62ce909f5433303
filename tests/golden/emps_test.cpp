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
  Measurement measurement = measured(path);
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

// From inertia alone to the last step, as with --effects inertia --stepwise.
TEST(Emps, AllStepsFromInertiaAlone) {
  const auto path = shared_file("emps/emps_estimation.csv");
  SKIP_WITHOUT(path);
  Measurement measurement = measured(path);
  const Diagnosis diagnosis = diagnose(measurement, {.baseline = {"inertia"}, .start = {}, .progress = {}});
  ASSERT_GE(diagnosis.steps.size(), 5u);
  for (std::size_t i = 1; i < diagnosis.steps.size(); ++i) {
    EXPECT_LT(diagnosis.steps[i].holdout_rmse_N, diagnosis.steps[i - 1].holdout_rmse_N);
    EXPECT_FALSE(diagnosis.steps[i].evidence.empty()) << "no physical reading";
    EXPECT_LT(diagnosis.steps[i].criterion_difference, 0.0) << diagnosis.steps[i].effect;
  }
  const FittedModel& last = diagnosis.explained;
  // Published with friction by direction: 3.11 % [5].
  EXPECT_LT(last.relative_error, 0.026);
  EXPECT_GT(last.relative_error, 0.015);
  const double force_N = measurement.weighted_rms(last.linearisation->measured_N());
  EXPECT_LT(last.holdout_rmse_N / force_N, 0.029);
  // Viscous friction opposes the motion in both directions.
  const double viscous = find_term(last.terms, "viscous")->gains[0];
  const Term* direction = find_term(last.terms, "direction_asymmetry");
  ASSERT_NE(direction, nullptr);
  EXPECT_GT(viscous, std::abs(direction->gains.back()));
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
