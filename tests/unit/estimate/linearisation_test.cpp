// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/linearisation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/estimate/linear/run_effect.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

using test::Draw;

Terms linear_model(const Measurement& measurement, std::uint64_t seed) {
  Terms terms;
  for (const Term& term : test::full_model(measurement, seed)) {
    if (!term.effect->acts_as(Acts::dry_scale) && !term.effect->acts_as(Acts::total_scale))
      terms.push_back(term);
  }
  return terms;
}

TEST(Linearisation, ColumnsTimesGainsIsTheForceOfALinearModel) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 12'000));
  const Terms terms = linear_model(measurement, 2);
  const Linearisation linearisation(measurement, terms);
  const Eigen::VectorXd force = linearisation.columns() * gains_of(terms);
  const Eigen::VectorXd direct = measurement.filtered(evaluate_force(measurement, terms).force_N);
  EXPECT_LT((force - direct).norm(), 1e-12 * direct.norm());
  EXPECT_LT((linearisation.force_N() - direct).norm(), 1e-12 * direct.norm());
  // Then the target is the measured force itself.
  EXPECT_LT((linearisation.target() - linearisation.measured_N()).norm(), 1e-12 * direct.norm());
  EXPECT_GT(direct.norm(), 1.0);
}

// Each column is the derivative of the force by its gain: central differences of the evaluation, every effect
// in the model, with all their products.
TEST(Linearisation, ColumnsAreDerivativesOfTheFullModel) {
  const Measurement measurement(test::wandering_log(3, 2000.0, 6000));
  Terms terms = test::full_model(measurement, 4);
  const Linearisation linearisation(measurement, terms);
  Eigen::Index column = 0;
  for (Term& term : terms) {
    for (double& gain : term.gains) {
      const double kept = gain;
      const double step = 1e-3 * std::abs(kept);
      gain = kept + step;
      const Eigen::VectorXd above = measurement.filtered(evaluate_force(measurement, terms).force_N);
      gain = kept - step;
      const Eigen::VectorXd below = measurement.filtered(evaluate_force(measurement, terms).force_N);
      gain = kept;
      const Eigen::VectorXd derivative = (above - below) / (2.0 * step);
      const Eigen::VectorXd is = linearisation.columns().col(column++);
      // Where dry friction crosses zero, its sign may change within the step: an error of second order.
      EXPECT_LT((is - derivative).norm(), 1e-7 * derivative.norm()) << term.id() << ' ' << column;
      EXPECT_GT(derivative.norm(), 0.0) << term.id();
    }
  }
  EXPECT_EQ(column, linearisation.columns().cols());
}

// Target - columns x gains = residual at the point of linearisation, as the Gauss-Newton method requires.
TEST(Linearisation, TargetMatchesTheResidual) {
  const Measurement measurement(test::wandering_log(5, 2000.0, 6000));
  const Terms terms = test::full_model(measurement, 6);
  const Linearisation linearisation(measurement, terms);
  const Eigen::VectorXd left = linearisation.target() - linearisation.columns() * gains_of(terms);
  EXPECT_LT((left - linearisation.residual_N()).norm(), 1e-11 * linearisation.force_N().norm());
  const Eigen::VectorXd force = measurement.filtered(linearisation.sample_force_N());
  EXPECT_EQ((force - linearisation.force_N()).norm(), 0.0);
}

TEST(Linearisation, MovedToOtherGainsKeepsItsColumns) {
  const Measurement measurement(test::wandering_log(5, 2000.0, 6000));
  Terms terms = linear_model(measurement, 6);
  const Linearisation here(measurement, terms);
  for (Term& term : terms) {
    for (double& gain : term.gains) gain *= 1.5;
  }
  const Linearisation there(here, terms);
  EXPECT_EQ(there.columns(), here.columns());
  EXPECT_LT((there.columns() * gains_of(terms) - there.force_N()).norm(), 1e-12 * there.force_N().norm());
}

TEST(Linearisation, CopiedColumnsEqualBuiltOnes) {
  const Measurement measurement(test::wandering_log(7, 2000.0, 6000));
  Terms terms = linear_model(measurement, 8);
  const Linearisation known(measurement, without(terms, "viscous"));
  std::reverse(terms.begin(), terms.end());
  for (Term& term : terms) {
    for (double& gain : term.gains) gain += 0.1;
  }
  const Linearisation built(measurement, terms);
  const Linearisation lent(measurement, terms, &known);
  EXPECT_EQ(lent.columns(), built.columns());
  EXPECT_EQ(lent.target(), built.target());
}

// Columns with other shapes, or multiplied by other effects, must not be copied.
TEST(Linearisation, CopiesNoColumnsThatHaveChanged) {
  const Measurement measurement(test::wandering_log(7, 2000.0, 6000));
  Terms terms = linear_model(measurement, 8);
  const Linearisation known(measurement, terms);
  Terms moved = terms;
  for (Term& term : moved) {
    for (double& shape : term.shapes) shape *= 1.1;
  }
  EXPECT_EQ(Linearisation(measurement, moved, &known).columns(), Linearisation(measurement, moved).columns());
  const Terms full = test::full_model(measurement, 8);
  EXPECT_EQ(Linearisation(measurement, full, &known).columns(), Linearisation(measurement, full).columns());
  const Linearisation with_products(measurement, full);
  EXPECT_EQ(Linearisation(measurement, terms, &with_products).columns(), known.columns());
}

// The columns of a candidate are those it would have in the model, at gain zero.
TEST(Linearisation, CandidateColumnsAreThoseOfTheWiderModel) {
  const Measurement measurement(test::wandering_log(9, 2000.0, 6000));
  for (const EffectDescription& effect : catalogue()) {
    if (effect.gain_count == 0 || effect.acts_as(Acts::dry)) continue;
    Terms terms = without(test::full_model(measurement, 10), effect.text.id);
    Draw draw(11);
    Term candidate = test::random_term(measurement, effect.text.id, draw);
    std::fill(candidate.gains.begin(), candidate.gains.end(), 0.0);
    const Linearisation base(measurement, terms);
    const Eigen::MatrixXd is = base.columns_of(candidate);
    terms.push_back(candidate);
    const Linearisation wider(measurement, terms);
    const Eigen::MatrixXd should = wider.columns().rightCols(effect.gain_count);
    EXPECT_LT((is - should).norm(), 1e-12 * should.norm()) << effect.id();
    EXPECT_LT((base.force_N() - wider.force_N()).norm(), 1e-14 * base.force_N().norm()) << effect.id();
  }
}

TEST(Linearisation, LagMovesTheMeasuredForce) {
  const Measurement measurement(test::wandering_log(12, 2000.0, 6000));
  Terms terms = linear_model(measurement, 13);
  for (Term& term : terms) {
    if (term.id() == "time_delay") term.shapes = {0.0031, 0.0012};
  }
  EXPECT_EQ(measurement_dynamics_of(terms).delay_s, 0.0031);
  EXPECT_EQ(measurement_dynamics_of(terms).filter_s, 0.0012);
  const Linearisation linearisation(measurement, terms);
  EXPECT_EQ(linearisation.measured_N(), measurement.force_N({0.0031, 0.0012}));
  EXPECT_EQ(measurement_dynamics_of({}).total_s(), 0.0);
}

// Force of the same effects with other gains and other shapes, without evaluating what is linear.
TEST(Linearisation, ForceAtOtherParametersIsThatOfTheModelThere) {
  const Measurement measurement(test::wandering_log(14, 2000.0, 6000));
  const Terms full = test::full_model(measurement, 15);
  Terms modulated;
  for (const Term& term : full) {
    if (!term.effect->acts_as(Acts::total_scale)) modulated.push_back(term);
  }
  for (const Terms& terms : {full, modulated, linear_model(measurement, 15)}) {
    const Linearisation here(measurement, terms);
    for (std::size_t changed = 0; changed <= terms.size(); ++changed) {
      Terms moved = terms;
      if (changed < terms.size()) {
        for (double& shape : moved[changed].shapes) shape *= 1.05;
      } else {
        for (Term& term : moved) {
          for (double& gain : term.gains) gain *= 1.02;
        }
      }
      const Eigen::VectorXd should = residual_of(measurement, moved);
      EXPECT_LT((here.residual_at(moved) - should).norm(), 1e-12 * here.force_N().norm()) << changed;
    }
  }
}

// The sum of gain x basis, evaluated together: every effect, with gains that are zero among them.
TEST(Linearisation, ContributionIsGainsTimesBasis) {
  const Measurement measurement(test::wandering_log(16, 2000.0, 3000));
  Draw draw(17);
  for (const EffectDescription& effect : catalogue()) {
    if (effect.gain_count == 0) continue;
    for (const std::size_t every : {1U, 2U, 3U, 7U}) {
      Term term = test::random_term(measurement, effect.text.id, draw);
      for (std::size_t g = 0; g < term.gains.size(); ++g) {
        if (g % every != 0) term.gains[g] = 0.0;
      }
      const std::vector<double> dry_N(measurement.sample_count(), -1.0);
      std::vector<double> is(measurement.sample_count(), 0.0);
      for (const Acts acts : {Acts::force, Acts::dry, Acts::dry_scale, Acts::total_scale})
        add_contribution(measurement, term, acts, dry_N, is);
      double worst = 0.0;
      double largest = 0.0;
      run_basis_of(measurement, term, dry_N, [&](std::size_t first, std::size_t count, const double* basis) {
        for (std::size_t i = first; i < first + count; ++i) {
          double should = 0.0;
          for (const double gain : term.gains) should += gain * *basis++;
          worst = std::max(worst, std::abs(is[i] - should));
          largest = std::max(largest, std::abs(should));
        }
      });
      EXPECT_LE(worst, 1e-13 * largest) << effect.id() << ' ' << every;
      EXPECT_GT(largest, 0.0) << effect.id();
    }
  }
}

double rms(const std::vector<double>& is, const std::vector<double>& should, std::size_t first) {
  double sum = 0.0;
  for (std::size_t i = first; i < is.size(); ++i) sum += (is[i] - should[i]) * (is[i] - should[i]);
  return std::sqrt(sum / static_cast<double>(is.size() - first));
}

// At a reversal between two samples the axis moves several micrometres to and fro. The hysteresis must agree
// with one that is sampled 64 times as often.
TEST(Linearisation, HysteresisPassesTurningPointsBetweenSamples) {
  constexpr double kRate_Hz = 1000.0;
  constexpr std::size_t kCount = 8000;
  constexpr std::size_t kFiner = 64;
  const auto position_m = [](double t) { return 0.03 * std::sin(14.5 * t) + 2e-3 * std::sin(33.1 * t); };
  const auto read_m = [&](double t) { return std::round(position_m(t) / 1e-8) * 1e-8; };
  Log log = test::log_of(kRate_Hz, kCount, read_m, [](double) { return 0.0; });
  log.encoder_resolution_m = 1e-8;
  const Measurement measurement(log);
  Term hysteresis = make_term(measurement, *find_effect("presliding_hysteresis"));
  const std::size_t element = hysteresis.shapes.size() / 2;
  hysteresis.shapes[element] = 5e-6;
  std::fill(hysteresis.gains.begin(), hysteresis.gains.end(), 0.0);
  hysteresis.gains[element] = 1.0 / 5e-6;

  const auto stops = [&](std::size_t finer) {
    std::vector<double> force_N;
    double z_m = 0.0;
    double last_m = read_m(0.0);
    for (std::size_t i = 0; i < kCount * finer; ++i) {
      const double x_m = i % finer == 0 ? log.position_m[i / finer]
                                        : position_m(static_cast<double>(i) / (kRate_Hz * double(finer)));
      z_m = std::clamp(z_m + x_m - last_m, -5e-6, 5e-6);
      last_m = x_m;
      if (i % finer == 0) force_N.push_back(z_m / 5e-6);
    }
    return force_N;
  };
  const std::vector<double> truth_N = stops(kFiner);
  const std::vector<double> blind_N = stops(1);
  const std::vector<double> is_N = evaluate_force(measurement, {hysteresis}).force_N;
  EXPECT_GT(rms(blind_N, truth_N, 100), 0.005);
  EXPECT_LT(rms(is_N, truth_N, 100), 0.1 * rms(blind_N, truth_N, 100));
  EXPECT_GT(measurement.turning_points(0, kCount).size(), 20U);
}

// A movement that ends between two samples has no turning point, nor has one with steps of the encoder's
// size.
TEST(Linearisation, AStopIsNoTurningPoint) {
  const auto there_and_wait = [](double t) {
    return 0.2 * std::clamp(std::abs(std::fmod(t + 0.25, 1.0) - 0.5), 0.1003, 0.4003);
  };
  Log log = test::log_of(1000.0, 4000, there_and_wait, [](double) { return 0.0; });
  log.encoder_resolution_m = 1e-8;
  EXPECT_TRUE(Measurement(log).turning_points(0, 4000).empty());
  Log slow = test::log_of(
      1000.0, 4000, [](double t) { return std::round(1e-4 * std::sin(5.0 * t) / 1e-6) * 1e-6; },
      [](double) { return 0.0; });
  slow.encoder_resolution_m = 1e-6;
  EXPECT_TRUE(Measurement(slow).turning_points(0, 4000).empty());
}

}  // namespace
}  // namespace slipstack::workbench
