// SPDX-License-Identifier: Apache-2.0
// Standard errors against the scatter of many repeated measurements.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "sim_host/log/closed_loop.h"
#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Draw;

/// Gauss-Markov noise with a correlation length of `memory_rows`.
VectorXd remembering_noise(Draw& draw, Index rows, double memory_rows) {
  const double keep = std::exp(-1.0 / memory_rows);
  VectorXd noise(rows);
  double state = draw.normal();
  for (Index row = 0; row < rows; ++row) {
    noise(row) = state;
    state = keep * state + std::sqrt(1.0 - keep * keep) * draw.normal();
  }
  return noise;
}

struct Calibration {
  double coverage = 0.0;        ///< share of intervals of two standard errors that hold the truth
  double ratio = 0.0;           ///< mean standard error over the scatter of the estimates
  double naive_coverage = 0.0;  ///< the same for standard errors that take residuals to be independent
};

/// Fits four unknowns, one of them a constant, to many records with correlated noise.
Calibration calibrate(double memory_rows, int repetitions, bool with_bounds) {
  const Measurement measurement(test::wandering_log(1, 1000.0, 20'000));
  const Index rows = measurement.row_count();
  const Index n = 4;
  Draw draw(2);
  MatrixXd columns(rows, n);
  columns.col(0).setOnes();
  for (Index i = 1; i < n; ++i) columns.col(i) = remembering_noise(draw, rows, memory_rows);
  const VectorXd truth = VectorXd::LinSpaced(n, 1.0, 2.0);
  NormalEquations::Constraints constraints{VectorXd::Constant(n, -1e9), VectorXd::Constant(n, 1e9),
                                           MatrixXd::Zero(n, n)};
  if (with_bounds) constraints.lower.setZero();
  const MatrixXd inverse = (columns.transpose() * columns).inverse();
  Calibration result;
  double errors = 0.0;
  double scatter = 0.0;
  for (int k = 0; k < repetitions; ++k) {
    const VectorXd target = columns * truth + 0.5 * remembering_noise(draw, rows, memory_rows);
    const NormalEquations equations(measurement, columns, target);
    const BoundedSolution solution = equations.fit(constraints);
    const VectorXd error = equations.standard_errors(solution, constraints);
    const double sigma = std::sqrt(equations.squared_error(solution.value) / static_cast<double>(rows - n));
    for (Index i = 0; i < n; ++i) {
      const double off = std::abs(solution.value(i) - truth(i));
      result.coverage += off < 2.0 * error(i) ? 1.0 : 0.0;
      result.naive_coverage += off < 2.0 * sigma * std::sqrt(inverse(i, i)) ? 1.0 : 0.0;
      errors += error(i) * error(i);
      scatter += off * off;
    }
  }
  result.coverage /= repetitions * static_cast<double>(n);
  result.naive_coverage /= repetitions * static_cast<double>(n);
  result.ratio = std::sqrt(errors / scatter);
  return result;
}

TEST(StandardErrors, CoverTheTruthForIndependentNoise) {
  const Calibration is = calibrate(0.01, 300, false);
  EXPECT_GT(is.coverage, 0.88);
  EXPECT_LT(is.coverage, 0.98);
  EXPECT_NEAR(is.ratio, 1.0, 0.1);
}

TEST(StandardErrors, CoverTheTruthForCorrelatedNoise) {
  const Calibration is = calibrate(5.0, 400, true);
  EXPECT_GT(is.coverage, 0.85);
  EXPECT_LT(is.coverage, 0.99);
  EXPECT_NEAR(is.ratio, 1.0, 0.15);
  EXPECT_LT(is.naive_coverage, 0.75);  // the coverage of standard errors that assume independence
}

/// Share of intervals of one standard error that contain the true value of an unknown that so many of thirty
/// blocks determine; and the same for sandwich errors without corrections.
struct FewBlocks {
  double coverage = 0.0;
  double plain_coverage = 0.0;
};

FewBlocks fits_of_what_few_blocks_show(int shown, double lower, int repetitions) {
  const Measurement measurement(test::wandering_log(11, 1000.0, 20'000));
  const Index rows = measurement.row_count();
  Draw draw(12);
  MatrixXd columns(rows, 2);
  columns.col(0).setOnes();
  for (Index row = 0; row < rows; ++row) {
    const int block = measurement.row_blocks()[static_cast<std::size_t>(row)];
    columns(row, 1) = block % 7 == 3 && block / 7 < shown ? 1.0 + 0.2 * draw.normal() : 0.0;
  }
  const Eigen::Vector2d truth(1.0, 0.0);
  const NormalEquations::Constraints constraints{Eigen::Vector2d(-1e9, lower), VectorXd::Constant(2, 1e9),
                                                 MatrixXd::Zero(2, 2)};
  const MatrixXd inverse = (columns.transpose() * columns).inverse();
  FewBlocks result;
  for (int k = 0; k < repetitions; ++k) {
    const VectorXd target = columns * truth + 0.5 * remembering_noise(draw, rows, 3.0);
    const NormalEquations equations(measurement, columns, target);
    const BoundedSolution solution = equations.fit(constraints);
    const double error = equations.standard_errors(solution, constraints)(1);
    VectorXd score = VectorXd::Zero(measurement.block_count());
    const VectorXd influence = columns * inverse.col(1);
    const VectorXd residual = target - columns * solution.value;
    for (Index row = 0; row < rows; ++row) {
      score(measurement.row_blocks()[static_cast<std::size_t>(row)]) += influence(row) * residual(row);
    }
    const double off = std::abs(solution.value(1) - truth(1));
    result.coverage += off < error ? 1.0 / repetitions : 0.0;
    result.plain_coverage += off < score.norm() ? 1.0 / repetitions : 0.0;
  }
  return result;
}

// An unknown that only three blocks determine: the fit makes their residuals smaller than their noise, and
// there are few of them.
TEST(StandardErrors, CoverTheTruthWhereFewBlocksDetermineIt) {
  for (const int shown : {3, 4}) {
    const FewBlocks is = fits_of_what_few_blocks_show(shown, -1e9, 500);
    EXPECT_GT(is.coverage, 0.60) << shown;
    EXPECT_LT(is.coverage, 0.80) << shown;
    EXPECT_LT(is.plain_coverage, 0.60) << shown;
  }
}

TEST(StandardErrors, AreZeroAtABound) {
  const Measurement measurement(test::wandering_log(3, 1000.0, 6000));
  Draw draw(4);
  const MatrixXd columns = draw.matrix(measurement.row_count(), 3);
  const VectorXd target =
      columns * Eigen::Vector3d(1.0, -1.0, 2.0) + 0.1 * draw.matrix(measurement.row_count(), 1);
  NormalEquations::Constraints constraints{Eigen::Vector3d(0.0, 0.0, 1.5), Eigen::Vector3d(5.0, 5.0, 1.5),
                                           MatrixXd::Zero(3, 3)};
  const NormalEquations equations(measurement, columns, target);
  const BoundedSolution solution = equations.fit(constraints);
  const VectorXd errors = equations.standard_errors(solution, constraints);
  EXPECT_GT(errors(0), 0.0);
  EXPECT_EQ(errors(1), 0.0);
  EXPECT_EQ(errors(2), 0.0);
}

// Units are the user's choice: metres or micrometres, the error goes with the value.
TEST(StandardErrors, ScaleWithTheUnit) {
  const Measurement measurement(test::wandering_log(5, 1000.0, 6000));
  Draw draw(6);
  MatrixXd columns = draw.matrix(measurement.row_count(), 3);
  const VectorXd target = draw.matrix(measurement.row_count(), 1);
  const NormalEquations::Constraints constraints{VectorXd::Constant(3, -1e12), VectorXd::Constant(3, 1e12),
                                                 MatrixXd::Zero(3, 3)};
  const auto errors_of = [&] {
    const NormalEquations equations(measurement, columns, target);
    return equations.standard_errors(equations.fit(constraints), constraints);
  };
  const VectorXd before = errors_of();
  columns.col(1) *= 1e6;
  const VectorXd after = errors_of();
  EXPECT_NEAR(after(1) * 1e6 / before(1), 1.0, 1e-6);
  EXPECT_NEAR(after(0) / before(0), 1.0, 1e-6);
}

/// The force of viscous friction and of a ripple over one pitch, on a motion that wanders.
Terms ripple_model(const Measurement& measurement) {
  Terms terms{make_term(measurement, *find_effect("viscous")),
              make_term(measurement, *find_effect("force_ripple"))};
  terms[0].gains = {4.0};
  terms[1].shapes[0] = 0.024;
  terms[1].gains[0] = 0.4;
  terms[1].gains[1] = -0.3;
  return terms;
}

struct Estimate {
  double value = 0.0;
  double error = 0.0;
};

/// What many records of that axis give for the pitch and for the amplitude of its first harmonic.
std::vector<std::vector<Estimate>> repeated_fits(int repetitions) {
  std::vector<std::vector<Estimate>> estimates(2);
  Log log = test::wandering_log(7, 1000.0, 14'000);
  const Terms truth = ripple_model(Measurement(log));
  const std::vector<double> force_N = evaluate_force(Measurement(log), truth).force_N;
  Draw draw(8);
  for (int k = 0; k < repetitions; ++k) {
    for (std::size_t i = 0; i < force_N.size(); ++i) log.force_N[i] = force_N[i] + 0.5 * draw.normal();
    const Measurement measurement(log);
    const Terms found =
        with_standard_errors(measurement, fit_effects(measurement, {"viscous", "force_ripple"}, {})).terms;
    const Term& ripple = *find_term(found, "force_ripple");
    estimates[0].push_back({ripple.shapes[0], ripple.shape_standard_errors[0]});
    estimates[1].push_back({ripple.gains[0], ripple.gain_standard_errors[0]});
  }
  return estimates;
}

TEST(StandardErrors, OfShapesMatchTheScatterOfRepeatedRecords) {
  const double truth[] = {0.024, 0.4};
  const auto estimates = repeated_fits(60);
  for (std::size_t which = 0; which < estimates.size(); ++which) {
    double scatter = 0.0;
    double errors = 0.0;
    int inside = 0;
    for (const Estimate& estimate : estimates[which]) {
      const double off = std::abs(estimate.value - truth[which]);
      scatter += off * off;
      errors += estimate.error * estimate.error;
      inside += off < 2.0 * estimate.error ? 1 : 0;
    }
    EXPECT_GT(std::sqrt(errors / scatter), 0.75) << which;
    EXPECT_LT(std::sqrt(errors / scatter), 1.35) << which;
    EXPECT_GE(inside, 50) << which;
  }
}

// The phase of the ripple depends on its pitch: standard errors of the gains that take the pitch for known
// are too small.
TEST(StandardErrors, OfGainsIncludeTheUncertaintyOfThePitch) {
  Log log = test::wandering_log(9, 1000.0, 12'000);
  for (double& position_m : log.position_m) position_m += 0.1;  // far from the origin of the phase
  const Terms truth = ripple_model(Measurement(log));
  const std::vector<double> force_N = evaluate_force(Measurement(log), truth).force_N;
  Draw draw(10);
  for (std::size_t i = 0; i < force_N.size(); ++i) log.force_N[i] = force_N[i] + 0.5 * draw.normal();
  const Measurement measurement(log);
  const FittedModel fitted = fit_gains(measurement, truth);
  const Eigen::VectorXd held = fitted.equations->standard_errors(fitted.solution, fitted.constraints);
  const Terms jointly = with_standard_errors(measurement, fitted).terms;
  EXPECT_GT(jointly[1].gain_standard_errors[0], 0.99 * held(1));
  EXPECT_GT(jointly[1].gain_standard_errors[1], 0.99 * held(2));
  EXPECT_GT(jointly[1].gain_standard_errors[0] + jointly[1].gain_standard_errors[1],
            1.05 * (held(1) + held(2)));
}

// The force is free of noise: only the encoder's grid changes the offset from record to record, or biases it
// in all.
TEST(StandardErrors, IncludeTheEncodersQuantisation) {
  double squares = 0.0;
  double scatter = 0.0;
  for (const std::uint64_t seed : {21U, 22U, 23U, 24U, 25U, 26U}) {
    sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
    bench.programme.seconds = 15.0;
    bench.axis.force_noise_N = 1e-6;
    bench.axis.encoder_resolution_m *= 2.0;
    Measurement measurement(test::simulate(bench, seed));
    weigh_rows(measurement);
    const Terms terms =
        with_standard_errors(
            measurement, fit_effects(measurement, {"inertia", "presliding_hysteresis", "offset_force"}, {}))
            .terms;
    const double error = terms[2].gain_standard_errors[0];
    scatter += std::pow(terms[2].gains[0] / error, 2);
    squares += 1.0;
  }
  EXPECT_GT(std::sqrt(scatter / squares), 0.2);
  EXPECT_LT(std::sqrt(scatter / squares), 1.5);
}

// Errors that recur in every block move an unknown by the mean of them; errors that differ from block to
// block are known to standard_errors(), and are not counted twice.
TEST(StandardErrors, OfErrorsThatRecurCountWhatScatterDoesNotContain) {
  const Measurement measurement(test::wandering_log(12, 1000.0, 20'000));
  const Index rows = measurement.row_count();
  Draw draw(13);
  const MatrixXd columns = MatrixXd::Ones(rows, 1);
  const NormalEquations::Constraints constraints{VectorXd::Constant(1, -1e9), VectorXd::Constant(1, 1e9),
                                                 MatrixXd::Zero(1, 1)};
  const NormalEquations equations(measurement, columns, draw.matrix(rows, 1));
  const BoundedSolution solution = equations.fit(constraints);
  const auto variance_of = [&](const VectorXd& error_N) {
    return equations.recurring_variance(measurement, columns, {error_N, -error_N}, solution, constraints)(0);
  };
  const double blocks = measurement.block_count();
  EXPECT_NEAR(variance_of(VectorXd::Constant(rows, 0.3)), 0.09 * (1.0 - 1.0 / blocks), 1e-3);
  VectorXd alternating(rows);
  for (Index row = 0; row < rows; ++row) {
    alternating(row) = measurement.row_blocks()[static_cast<std::size_t>(row)] % 2 == 0 ? 0.3 : -0.3;
  }
  EXPECT_LT(variance_of(alternating), 1e-4);
}

// A mode above the range of the search ends at its bound, and the log determines its damping only as far as
// its frequency.
TEST(StandardErrors, ContainWhatABoundOfTheSearchHides) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, 2026112403);
  const sim::MotionProgramme programme = sim::draw_programme(bench, 2026112403);
  sim::add_effects(bench.axis, {sim::EffectId::kStructuralResonance}, programme, bench.rate_Hz, 0.0,
                   2026112403);
  const Log log = test::log_of(
      bench.axis, sim::simulate_closed_loop_log(bench.axis, programme, bench.rate_Hz, 2026112403));
  ConditioningOptions narrower;  // modes are searched up to 1.2 times the band
  narrower.bandwidth_Hz = Measurement(log).bandwidth_Hz() / 1.2;
  Measurement measurement(log, narrower);
  weigh_rows(measurement);
  const FittedModel fitted =
      fit_effects(measurement, {"inertia", "presliding_hysteresis", "structural_resonance"}, {});
  const Term mode = *find_term(with_standard_errors(measurement, fitted).terms, "structural_resonance");
  ASSERT_EQ(mode.shape_standard_errors[0], 0.0) << "the frequency is at its bound";
  EXPECT_LT(std::abs(mode.shapes[1] - 0.0583), 2.0 * mode.shape_standard_errors[1]);
  EXPECT_LT(mode.shape_standard_errors[1], 0.03);
}

// Under control the noise moves the axis, and viscous friction comes out too large, in every record alike:
// the motion along the reference shows by how much.
TEST(StandardErrors, ContainTheBiasUnderControlWhereTheLogHasTheReference) {
  constexpr std::uint64_t kSeed = 9;
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, kSeed);
  const sim::MotionProgramme programme = sim::draw_programme(bench, kSeed);
  sim::add_effects(bench.axis, {sim::EffectId::kViscous}, programme, bench.rate_Hz, 0.0, kSeed);
  const Log log =
      test::log_of(bench.axis, sim::simulate_closed_loop_log(bench.axis, programme, bench.rate_Hz, kSeed));
  const auto viscous_of = [](Log own) {
    Measurement measurement(std::move(own));
    weigh_rows(measurement);
    return *find_term(
        with_standard_errors(measurement,
                             fit_effects(measurement, {"inertia", "presliding_hysteresis", "viscous"}, {}))
            .terms,
        "viscous");
  };
  ASSERT_EQ(log.reference_position_m.size(), log.position_m.size());
  const Term with = viscous_of(log);
  Log without_reference = log;
  without_reference.reference_position_m.clear();
  const Term without = viscous_of(without_reference);
  Log follows_exactly = log;
  follows_exactly.reference_position_m = log.position_m;
  const Term prescribed = viscous_of(follows_exactly);
  EXPECT_EQ(with.gains[0], without.gains[0]);
  EXPECT_GT(with.gain_standard_errors[0], 1.15 * without.gain_standard_errors[0]);
  EXPECT_LT(with.gain_standard_errors[0], 3.0 * without.gain_standard_errors[0]);
  EXPECT_EQ(prescribed.gain_standard_errors[0], without.gain_standard_errors[0]);
}

// The level of a hysteresis is better known than its elements, whose errors cancel.
TEST(StandardErrors, OfTheLevelAreThoseOfTheSum) {
  Draw draw(17);
  const Measurement measurement(test::wandering_log(12, 1000.0, 20'000));
  const Index rows = measurement.row_count();
  MatrixXd columns(rows, 2);
  columns.col(0) = draw.matrix(rows, 1);
  columns.col(1) = columns.col(0) + 0.1 * draw.matrix(rows, 1);
  const NormalEquations::Constraints constraints{VectorXd::Constant(2, -1e9), VectorXd::Constant(2, 1e9),
                                                 MatrixXd::Zero(2, 2)};
  const NormalEquations equations(measurement, columns,
                                  VectorXd(columns.rowwise().sum() + draw.matrix(rows, 1)));
  const VectorXd errors =
      equations.standard_errors(equations.fit(constraints), constraints, VectorXd::Ones(2));
  ASSERT_EQ(errors.size(), 3);
  // Of the sum of both gains on a common column: that of one gain on that column alone.
  EXPECT_NEAR(errors(2), 1.0 / std::sqrt(static_cast<double>(rows)),
              0.25 / std::sqrt(static_cast<double>(rows)));
  EXPECT_GT(errors(0), 5.0 * errors(2));
}

TEST(StandardErrors, AreZeroForTheShapesOfAnEffectWithoutForce) {
  Log log = test::wandering_log(10, 1000.0, 6000);
  const std::vector<double> force_N =
      evaluate_force(Measurement(log), ripple_model(Measurement(log))).force_N;
  for (std::size_t i = 0; i < force_N.size(); ++i) log.force_N[i] += force_N[i];
  const Measurement measurement(log);
  FittedModel fitted = fit_gains(measurement, ripple_model(measurement));
  for (double& gain : fitted.terms[1].gains) gain = 0.0;
  const Terms terms = with_standard_errors(measurement, fitted).terms;
  EXPECT_EQ(terms[1].shape_standard_errors[0], 0.0);
  EXPECT_GT(terms[0].gain_standard_errors[0], 0.0);
}

}  // namespace
}  // namespace slipstack::workbench
