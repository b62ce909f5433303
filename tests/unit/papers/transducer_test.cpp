// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/transducer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim_host/rng.h"

// The calibration of [3] on simulated records, and each part of it on records whose answer is known.
namespace slipstack::workbench {
namespace {

/// A record of a transducer that is a model itself, at the given loads.
std::vector<sim::LoadStep> record_of(TransducerModel model, const std::vector<double>& loads,
                                     double drift_per_s) {
  std::vector<sim::LoadStep> steps;
  for (const double load : loads) {
    const double t = 45.0 * static_cast<double>(steps.size() + 1);
    steps.push_back({t, load, model.reading_at(load) + drift_per_s * t});
    model.move_to(load);
  }
  return steps;
}

std::vector<double> up_and_down(double step, int count) {
  std::vector<double> loads;
  for (int i = 0; i <= count; ++i) loads.push_back(step * i);
  for (int i = count; i-- > 0;) loads.push_back(step * i);
  return loads;
}

const std::vector<double> kTenths = up_and_down(100.0, 10);

TEST(Reversibility, SeparatesAKnownLinearityFromAKnownHysteresis) {
  // Quadratic linearity, a loop of known height between the branches, and a drift with time.
  std::vector<sim::LoadStep> steps;
  for (std::size_t i = 0; i < kTenths.size(); ++i) {
    const double u = kTenths[i] / 1000.0;
    const double way = i <= 10 ? 1.0 : -1.0;
    steps.push_back({10.0 * static_cast<double>(i), kTenths[i],
                     7.0 + 2.0 * u + 0.03 * u * (1.0 - u) + way * 0.01 * std::sin(3.14159265358979 * u) +
                         1e-4 * static_cast<double>(i)});
  }
  const Reversibility found = reversibility(step_record(steps));
  EXPECT_NEAR(found.sensitivity, (2.0 + 1e-3) / 1000.0, 1e-12);
  EXPECT_NEAR(found.zero_drift, 2e-3, 1e-12);
  EXPECT_NEAR(found.largest_hysteresis, 0.01, 1e-12);
  ASSERT_EQ(found.load_N.size(), 11u);
  for (std::size_t j = 0; j < 11; ++j) {
    const double u = found.load_N[j] / 1000.0;
    // The line takes the drift at full scale with it; on the average of both ways the rest cancels.
    EXPECT_NEAR(found.linearity[j], 0.03 * u * (1.0 - u) - 1e-3 * u, 1e-12);
    EXPECT_NEAR(found.hysteresis[j], 0.01 * std::sin(3.14159265358979 * u), 1e-12);
  }
}

TEST(TransducerModel, BisectionGivesTheLoadBackToNineDigits) {
  sim::Rng rng(6);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> stiffness;
    std::vector<double> slip;
    for (int i = 1; i <= 8; ++i) {
      stiffness.push_back(1e-6 * rng.uniform());
      slip.push_back(100.0 * i);
    }
    TransducerModel truth(2e-3, stiffness, slip, {0.0, 400.0, 1000.0}, {0.0, 1e-4, 0.0});
    TransducerModel corrected = truth;
    for (int i = 0; i < 200; ++i) {
      const double load = rng.uniform(0.0, 1000.0);
      const double found = corrected.load_of(truth.reading_at(load), 1000.0);
      EXPECT_NEAR(found, load, 1.1e-6);  // 1e-9 of full scale, and what was carried over
      truth.move_to(load);
      corrected.move_to(found);
    }
  }
}

// With elements at the steps and nothing else in the way, the formula of the paper is exact.
TEST(Extraction, FormulaFindsTheElementsOfACleanFirstRise) {
  const std::vector<double> slip{100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0, 900.0};
  const std::vector<double> stiffness{9e-7, 8e-7, 7e-7, 6e-7, 5e-7, 4e-7, 3e-7, 2e-7, 1e-7};
  const TransducerModel truth(2e-3, stiffness, slip, {}, {});
  const StepRecord record = step_record(record_of(truth, kTenths, 0.0));
  // A straight line as the linearity of the transducer: a record of a transducer without hysteresis.
  const StepRecord straight = step_record(record_of(TransducerModel(2e-3, {}, {}, {}, {}), kTenths, 0.0));
  const TransducerModel found = extract_by_formula(record, &straight);
  ASSERT_EQ(found.stiffness().size(), 9u);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(found.slip_N()[i], slip[i], 1e-9);
    EXPECT_NEAR(found.stiffness()[i], stiffness[i], 1e-12);
  }
}

TEST(Extraction, LoopThatReadsHigherOnTheWayDownHasNegativeStiffness) {
  const std::vector<double> slip{100.0, 300.0, 600.0};
  const TransducerModel truth(2e-3, {-9e-7, -5e-7, -3e-7}, slip, {}, {});
  const StepRecord record = step_record(record_of(truth, kTenths, 0.0));
  for (const TransducerModel& found : {extract_by_formula(record), extract_by_least_squares(record)}) {
    for (const double k : found.stiffness()) EXPECT_LT(k, 0.0);
    EXPECT_LT(errors_of(found, record).largest_mV_per_V,
              0.5 * errors_of(line_and_linearity(record), record).largest_mV_per_V);
  }
}

class SimulatedTransducer : public testing::TestWithParam<std::uint64_t> {
 protected:
  const sim::TransducerSetup setup_ = *sim::read_setup("transducer").transducer;
  const sim::SimulatedCalibration data_ = sim::simulate_calibration(setup_, GetParam());
  const StepRecord virgin_ = step_record(data_.virgin);
  const StepRecord loops_ = step_record(data_.loops);
  const StepRecord repeat_ = step_record(data_.repeat);
};

TEST_P(SimulatedTransducer, HasTheHysteresisOfThePaper) {
  EXPECT_EQ(loops_.preloads, 3u);
  EXPECT_EQ(virgin_.preloads, 0u);
  const Reversibility found = reversibility(loops_);
  EXPECT_NEAR(found.largest_hysteresis, 1.5e-4, 0.1e-4);
  EXPECT_EQ(found.load_N.size(), 11u);
  // A cycle after preloads closes, a first one does not: the zero drift that [3] explains by hysteresis.
  EXPECT_LT(std::fabs(found.zero_drift), 0.2e-4);
  EXPECT_GT(std::fabs(reversibility(virgin_).zero_drift), 1e-4);
}

TEST_P(SimulatedTransducer, FormulaLeavesAtMostAThirdAndLeastSquaresLess) {
  const double hysteresis = reversibility(repeat_).largest_hysteresis;
  const TransducerErrors before = errors_of(line_and_linearity(loops_), repeat_);
  const TransducerErrors formula = errors_of(extract_by_formula(loops_), repeat_);
  const TransducerErrors squares = errors_of(extract_by_least_squares(loops_), repeat_);
  EXPECT_NEAR(before.largest_mV_per_V, hysteresis, 0.15 * hysteresis);
  EXPECT_LT(formula.largest_mV_per_V, hysteresis / 3.0);
  EXPECT_GT(formula.largest_mV_per_V, 0.05 * hysteresis);
  EXPECT_LT(squares.largest_mV_per_V, 0.5 * formula.largest_mV_per_V);
  EXPECT_GT(squares.largest_mV_per_V, setup_.noise_mV_per_V);
  // The loads follow: mV/V over the sensitivity.
  const double sensitivity = setup_.sensitivity_mV_per_V / setup_.full_scale_N;
  for (const TransducerErrors& errors : {before, formula, squares}) {
    EXPECT_NEAR(errors.largest_load_N, errors.largest_mV_per_V / sensitivity, 0.25 * errors.largest_load_N);
  }
  EXPECT_LT(squares.uncertainty_N, 0.2 * before.uncertainty_N);
}

TEST_P(SimulatedTransducer, FirstRiseServesLeastSquaresBetterThanTheFormula) {
  const double hysteresis = reversibility(loops_).largest_hysteresis;
  const auto left = [&](const TransducerModel& model) {
    return errors_of(with_line_of(model, loops_), loops_).largest_mV_per_V / hysteresis;
  };
  const double formula = left(extract_by_formula(virgin_));
  const double squares = left(extract_by_least_squares(virgin_));
  EXPECT_LT(formula, 0.55);
  EXPECT_GT(formula, 0.25);
  EXPECT_LT(squares, 0.25);
}

INSTANTIATE_TEST_SUITE_P(Seeds, SimulatedTransducer, testing::Range<std::uint64_t>(1, 11));

std::string refusal(std::vector<sim::LoadStep> steps) {
  try {
    const StepRecord record = step_record(std::move(steps));
    reversibility(record);
    extract_by_formula(record);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(StepRecord, RefusesWhatNoCalibrationIs) {
  const TransducerModel truth(2e-3, {1e-6}, {300.0}, {}, {});
  const std::vector<sim::LoadStep> good = record_of(truth, kTenths, 0.0);
  EXPECT_EQ(refusal(good), "");
  EXPECT_NE(refusal({}).find("no load steps"), std::string::npos);
  auto bad = good;
  bad[3].time_s = bad[2].time_s;
  EXPECT_NE(refusal(bad).find("step 4: time does not rise"), std::string::npos);
  bad = good;
  bad[3].load_N = -1.0;
  EXPECT_NE(refusal(bad).find("step 4: the load is negative"), std::string::npos);
  bad = good;
  bad[5].signal_mV_per_V = std::nan("");
  EXPECT_NE(refusal(bad).find("step 6"), std::string::npos);
  bad = good;
  bad.pop_back();
  EXPECT_NE(refusal(bad).find("must end at zero"), std::string::npos);
  EXPECT_NE(refusal(record_of(truth, up_and_down(250.0, 4), 0.0)).find("fewer than five"), std::string::npos);
  EXPECT_NE(refusal(record_of(truth, {0.0, 1000.0, 0.0}, 0.0)).find("no steps between"), std::string::npos);
  bad = good;
  for (sim::LoadStep& step : bad) step.signal_mV_per_V *= -1.0;
  EXPECT_NE(refusal(bad).find("does not grow"), std::string::npos);
  // Hysteresis that bends up and down: noise, not a curve.
  bad = good;
  for (std::size_t i = 1; i < 10; ++i) bad[i].signal_mV_per_V += (i % 2 == 0 ? 1e-3 : -1e-3);
  EXPECT_NE(refusal(bad).find("not concave"), std::string::npos);
}

}  // namespace
}  // namespace slipstack::workbench
