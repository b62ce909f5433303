// SPDX-License-Identifier: Apache-2.0
// The selection criterion: it does not depend on units or on the order of comparison, counts what correlated
// residuals make of a gain, and prefers an effect only where there is one.
#include "workbench/diagnose/evidence/criterion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "tests/unit/estimate/estimate_support.h"

namespace slipstack::workbench {
namespace {

/// A motion of several frequencies, over which force_N(t, v) acts.
Log log_with(double seconds, const std::function<double(double, double)>& force_N) {
  const auto position_m = [](double t) {
    return 0.05 * std::sin(2.3 * t) + 0.01 * std::sin(11.7 * t + 1.0) + 0.002 * std::sin(37.0 * t);
  };
  const auto velocity_mps = [](double t) {
    return 0.115 * std::cos(2.3 * t) + 0.117 * std::cos(11.7 * t + 1.0) + 0.074 * std::cos(37.0 * t);
  };
  return test::log_of(1000.0, static_cast<std::size_t>(1000.0 * seconds), position_m,
                      [&](double t) { return force_N(t, velocity_mps(t)); });
}

FittedModel fitted(const Measurement& measurement, const std::vector<const char*>& effects) {
  Terms terms;
  for (const char* id : effects) terms.push_back(make_term(measurement, *find_effect(id)));
  return fit_gains(measurement, std::move(terms));
}

/// By how much the criterion prefers an offset beside viscous friction; positive: it does.
double preference(const Measurement& measurement) {
  const FittedModel with = fitted(measurement, {"offset_force", "viscous"});
  const FittedModel without = fitted(measurement, {"viscous"});
  return -Criterion(measurement, without.terms, 1).difference(with, without);
}

TEST(Criterion, AGainCostsTheLogarithmOfTheRowsWhereResidualsAreIndependent) {
  int preferred = 0;
  double sum = 0.0;
  constexpr int kLogs = 24;
  for (int seed = 1; seed <= kLogs; ++seed) {
    test::Draw draw(static_cast<std::uint64_t>(seed));
    const Measurement measurement(log_with(20.0, [&](double, double v) { return 3.0 * v + draw.normal(); }));
    const double gain = preference(measurement);
    preferred += gain > 0.0 ? 1 : 0;
    sum += gain / std::log(measurement.row_weights().sum());
  }
  EXPECT_LE(preferred, 1);
  // Neighbouring rows share the band of the filter, so that about two are worth one independent row.
  EXPECT_LT(sum / kLogs, -0.7);
  EXPECT_GT(sum / kLogs, -2.5);
}

TEST(Criterion, IsNoSupportWhereItIsABareMention) {
  EXPECT_FALSE(is_supported(0.0));
  EXPECT_FALSE(is_supported(-1.99));
  EXPECT_TRUE(is_supported(-2.01));
}

// Rows that only repeat others are no evidence: the criterion is that of independent rows.
TEST(Criterion, OfAnEffectDoesNotGrowWithRowsThatRepeatOthers) {
  double least = 0.0;
  double most = 0.0;
  for (const double rate_Hz : {500.0, 4000.0}) {
    // A residual that is constant over half a second, whatever the rate.
    test::Draw draw(3);
    std::vector<double> held(80);
    for (double& value : held) value = draw.normal();
    const auto position_m = [](double t) {
      return 0.05 * std::sin(2.3 * t) + 0.01 * std::sin(11.7 * t + 1.0);
    };
    const Measurement measurement(
        test::log_of(rate_Hz, static_cast<std::size_t>(40.0 * rate_Hz), position_m, [&](double t) {
          const double v = 0.115 * std::cos(2.3 * t) + 0.117 * std::cos(11.7 * t + 1.0);
          return 6.0 * v + held[static_cast<std::size_t>(2.0 * t) % held.size()];
        }));
    const FittedModel with = fitted(measurement, {"offset_force", "viscous"});
    const FittedModel without = fitted(measurement, {"offset_force"});
    const double difference = Criterion(measurement, without.terms, 1).difference(with, without);
    least = rate_Hz < 1000.0 ? difference : least;
    most = difference;
  }
  EXPECT_LT(least, -2.0);
  EXPECT_NEAR(most / least, 1.0, 0.5);
}

TEST(Criterion, PrefersAnEffectThatIsThere) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    test::Draw draw(seed);
    const Measurement measurement(
        log_with(20.0, [&](double, double v) { return 0.5 + 3.0 * v + draw.normal(); }));
    EXPECT_GT(preference(measurement), 0.0) << seed;
  }
}

// Where the motion repeats, what the form of a model misses returns with it, wherever that is: an
// acceleration that another axis makes at the same phases.
TEST(Criterion, OfAMotionThatRepeatsIsThatOfOnePeriod) {
  const auto support = [](int periods) {
    test::Draw draw(6);
    const double period_s = 8.0;
    const auto phase = [&](double t) { return 2.0 * std::numbers::pi * t / period_s; };
    const Log log = test::log_of(
        500.0, static_cast<std::size_t>(500.0 * period_s * periods),
        [&](double t) { return 0.05 * std::cos(phase(t)) + 0.01 * std::cos(5.0 * phase(t)); },
        [&](double t) {
          return 0.3 * std::sin(3.0 * phase(t)) + 0.2 * std::sin(7.0 * phase(t) + 2.0) + 0.02 * draw.normal();
        });
    const Measurement measurement(log);
    const FittedModel with = fitted(measurement, {"cable_chain_stiffness", "viscous"});
    const FittedModel without = fitted(measurement, {"viscous"});
    return Criterion(measurement, without.terms, 1).difference(with, without);
  };
  const double of_four = support(4);
  EXPECT_NEAR(support(24), of_four, 0.35 * std::abs(of_four) + 3.0);
}

// A force that depends on the place, with an offset as a candidate: where one motion repeats, a wrong form
// recurs with every cycle, and more cycles are no more evidence.
TEST(Criterion, CyclesThatRepeatAreNoFurtherEvidence) {
  const auto of_cycles = [](double seconds) {
    test::Draw draw(5);
    const Log log = test::log_of(
        1000.0, static_cast<std::size_t>(1000.0 * seconds), [](double t) { return 0.1 * std::sin(6.0 * t); },
        [&](double t) {
          const double x = std::sin(6.0 * t);
          const double v = std::cos(6.0 * t);
          return 0.2 * v + 0.2 * std::cos(25.0 * x) + 0.01 * draw.normal();
        });
    return preference(Measurement(log));
  };
  // Independent evidence would be ten times as much.
  EXPECT_LT(of_cycles(100.0), std::max(3.0 * of_cycles(10.0), 0.0) + 1.0);
}

TEST(Criterion, DoesNotDependOnTheUnitOfTheForceOrOnTheOrder) {
  for (const double unit : {1.0, 1e-3, 4448.2}) {
    test::Draw draw(9);
    const Measurement measurement(log_with(20.0, [&](double t, double v) {
      return unit * (0.4 * v + 0.1 * std::sin(t) + 0.2 * draw.normal());
    }));
    const FittedModel one = fitted(measurement, {"offset_force", "viscous"});
    const FittedModel other = fitted(measurement, {"viscous"});
    const Criterion criterion(measurement, {}, 20);
    const double difference = criterion.difference(one, other);
    EXPECT_NEAR(difference, -criterion.difference(other, one), 1e-9 * std::abs(difference));
    test::Draw again(9);
    const Measurement newtons(log_with(
        20.0, [&](double t, double v) { return 0.4 * v + 0.1 * std::sin(t) + 0.2 * again.normal(); }));
    const Criterion in_newtons(newtons, {}, 20);
    EXPECT_NEAR(
        difference,
        in_newtons.difference(fitted(newtons, {"offset_force", "viscous"}), fitted(newtons, {"viscous"})),
        1e-3 * std::abs(difference));
  }
}

// A pitch is the best of many: the same effect with the same gains costs more when its pitch was searched.
TEST(Criterion, CountsWhatWasChosen) {
  test::Draw draw(3);
  const Measurement measurement(log_with(20.0, [&](double, double) { return draw.normal(); }));
  const FittedModel ripple = fitted(measurement, {"offset_force", "force_ripple"});
  const FittedModel plain = fitted(measurement, {"offset_force"});
  const double searched = Criterion(measurement, plain.terms, 1).difference(ripple, plain);
  const double given = Criterion(measurement, ripple.terms, 1).difference(ripple, plain);
  EXPECT_GT(searched, given + 2.0 * std::log(200.0));
  EXPECT_GT(Criterion(measurement, plain.terms, 20).difference(ripple, plain),
            searched + 2.0 * std::log(19.0));
}

}  // namespace
}  // namespace slipstack::workbench
