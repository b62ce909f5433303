// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/golden/shared_data.h"

// Measured pre-sliding loops of a tribometer.
namespace slipstack::workbench {
namespace {

Log half_of(Log log, bool first) {
  const auto middle = static_cast<std::ptrdiff_t>(log.position_m.size() / 2);
  const auto cut = [&](std::vector<double>& values) {
    if (values.empty()) return;
    if (first) {
      values.erase(values.begin() + middle, values.end());
    } else {
      values.erase(values.begin(), values.begin() + middle);
    }
  };
  for (auto* column : {&log.position_m, &log.force_N, &log.velocity_mps, &log.normal_force_N}) cut(*column);
  if (!first) log.start_time_s += static_cast<double>(middle) / log.sample_rate_Hz;
  return log;
}

TEST(Tribometer, FirstHalfPredictsTheSecond) {
  const auto path = shared_file("tribometer/tribometer_loops.csv");
  SKIP_WITHOUT(path);
  const Log log = read_log(path);
  const FittedModel fitted = fit_effects(Measurement(half_of(log, true)), {"presliding_hysteresis"}, {});
  const Measurement second(half_of(log, false));
  const Eigen::VectorXd measured_N = second.force_N();
  const Eigen::VectorXd model_N = second.filtered(evaluate_force(second, fitted.terms).force_N);
  const double relative = (measured_N - model_N).norm() / measured_N.norm();
  EXPECT_LE(relative, 0.05);
  EXPECT_GT(relative, 0.02);
}

TEST(Tribometer, TheModelIsNotCalledComplete) {
  const auto path = shared_file("tribometer/tribometer_loops.csv");
  SKIP_WITHOUT(path);
  Measurement measurement = measured(path);
  const Diagnosis diagnosis =
      diagnose(measurement, {.baseline = {"presliding_hysteresis"}, .start = {}, .progress = {}});
  EXPECT_NE(diagnosis.verdict, Verdict::complete);
  EXPECT_LT(diagnosis.baseline.relative_error, 0.055);
  if (diagnosis.verdict == Verdict::missing_effect) {
    const Candidate& first = diagnosis.candidates.front();
    EXPECT_GT(first.error_reduction, 2.0 * first.error_reduction_se);
    EXPECT_EQ(first.term.id(), "direction_asymmetry");  // as others found in these loops
  }
}

// The explanation of `diagnose --stepwise` and its held-out error. Its effects must be physical: none drives
// the contact, and no two cancel each other.
TEST(Tribometer, StepsArePhysical) {
  const auto path = shared_file("tribometer/tribometer_loops.csv");
  SKIP_WITHOUT(path);
  Measurement measurement = measured(path);
  const Diagnosis diagnosis =
      diagnose(measurement, {.baseline = {"presliding_hysteresis"}, .start = {}, .progress = {}});
  const FittedModel& last = diagnosis.explained;
  const double force_N = measurement.weighted_rms(last.linearisation->measured_N());
  RecordProperty("holdout_percent", std::to_string(100.0 * last.holdout_rmse_N / force_N));
  EXPECT_LE(last.holdout_rmse_N / force_N, 0.038);
  EXPECT_GT(last.holdout_rmse_N / force_N, 0.015);
  const Term* hysteresis = find_term(last.terms, "presliding_hysteresis");
  for (const double stiffness : hysteresis->gains) EXPECT_GE(stiffness, 0.0);
  const Term* asymmetry = find_term(last.terms, "direction_asymmetry");
  ASSERT_NE(asymmetry, nullptr);
  const Term* viscous = find_term(last.terms, "viscous");
  EXPECT_GE(viscous == nullptr ? 0.0 : viscous->gains[0], std::abs(asymmetry->gains[2]));
  // No term alone is larger than the measured force.
  for (const Term& term : last.terms) {
    if (term.effect->acts_as(Acts::dry_scale)) continue;
    const Eigen::VectorXd alone = measurement.filtered(evaluate_force(measurement, {term}).force_N);
    EXPECT_LT(measurement.weighted_rms(alone), 1.2 * force_N) << term.id();
  }
}

}  // namespace
}  // namespace slipstack::workbench
