// SPDX-License-Identifier: Apache-2.0
// The search for shapes: ranges, starting points, and what a fit finds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "sim_host/sensors/delay_line.h"
#include "tests/unit/estimate/estimate_support.h"
#include "workbench/base/statistics.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/nonlinear/minimise.h"
#include "workbench/estimate/nonlinear/starting_shapes.h"
#include "workbench/estimate/nonlinear/trial.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// Distance in the coordinates of the search.
double apart(const ShapeRange& range, double a, double b) {
  return range.logarithmic ? std::log(a / b) : (a - b) / (range.upper - range.lower);
}

TEST(ShapeSearch, RangesLieWithinTheCatalogue) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Log log = test::wandering_log(seed, 2000.0, 20'000);
    if (seed % 2 == 0) log.encoder_resolution_m = 1e-7;
    const Measurement measurement(log);
    for (const EffectDescription& effect : catalogue()) {
      for (const ShapeRange& range : searched_shapes(measurement, effect)) {
        const ShapeSpec& spec = effect.shapes[range.index];
        EXPECT_GE(range.lower, static_cast<double>(spec.lower)) << effect.id() << ' ' << spec.name;
        EXPECT_LE(range.upper, static_cast<double>(spec.upper)) << effect.id() << ' ' << spec.name;
        EXPECT_LE(range.lower, range.upper) << effect.id() << ' ' << spec.name;
        if (range.logarithmic) {
          EXPECT_GT(range.lower, 0.0) << effect.id() << ' ' << spec.name;
        }
      }
    }
  }
}

TEST(ShapeSearch, StartsLieWithinTheRanges) {
  const Measurement measurement(test::wandering_log(5, 2000.0, 20'000));
  test::Draw draw(6);
  const Eigen::VectorXd residual = draw.matrix(measurement.row_count(), 1);
  const Eigen::VectorXd force = draw.matrix(measurement.row_count(), 1);
  for (const EffectDescription& effect : catalogue()) {
    const auto starts = starting_shapes(measurement, effect, residual, force);
    ASSERT_FALSE(starts.empty()) << effect.id();
    for (const auto& shapes : starts) {
      ASSERT_EQ(shapes.size(), effect.shapes.size()) << effect.id();
      for (std::size_t i = 0; i < shapes.size(); ++i) {
        EXPECT_GE(shapes[i], static_cast<double>(effect.shapes[i].lower)) << effect.id();
        EXPECT_LE(shapes[i], static_cast<double>(effect.shapes[i].upper)) << effect.id();
      }
      for (const ShapeRange& range : searched_shapes(measurement, effect)) {
        EXPECT_GE(shapes[range.index], range.lower) << effect.id();
        EXPECT_LE(shapes[range.index], range.upper) << effect.id();
      }
    }
  }
}

/// A stroke of 1 m back and forth, at up to 1.1 m/s.
double moves_m(double time_s) {
  const auto quintic = [](double u) {
    const double within = std::clamp(u, 0.0, 1.0);
    return within * within * within * (10.0 - 15.0 * within + 6.0 * within * within);
  };
  const double u = std::fmod(time_s, 5.0) / 5.0;
  return quintic(u / 0.35) - quintic((u - 0.5) / 0.35);
}

/// By how many periods within the stroke the best of the starting pitches misses the pitch of a ripple, in a
/// log of these moves that take so many times as long.
double periods_missed(double pitch_m, double slower, double rate_Hz) {
  test::Draw draw(3);
  const auto position_m = [&](double t) { return moves_m(t / slower); };
  const Log log = test::log_of(rate_Hz, 20'000, position_m, [&](double t) {
    return std::sin(2.0 * std::numbers::pi / pitch_m * position_m(t) + 0.3) + 0.02 * draw.normal();
  });
  const Measurement measurement(log);
  const std::vector<double> nothing_N(measurement.sample_count(), 0.0);
  const EffectDescription& ripple = *find_effect("force_ripple");
  double least = 1e3;
  for (const auto& start :
       starting_shapes(measurement, ripple, measurement.force_N(), measurement.force_N(), nothing_N)) {
    least = std::min(least, std::abs(1.0 / start[0] - 1.0 / pitch_m));
  }
  return least;
}

// At 1.1 m/s a pitch of 14 mm passes at 77 Hz, above the bandwidth of 25 Hz: the rows see it near the two
// ends of the stroke alone, and any pitch that fits both. A start that is off by an eighth of a period (the
// step of the periodogram is a quarter) leaves a quarter of the amplitude, and such a pitch may leave less.
TEST(ShapeSearch, BeginsAtAPitchThatIsPassedFasterThanTheBandwidth) {
  for (const double pitch_m : {0.2, 49e-3, 33.2e-3, 20e-3, 14e-3, 11e-3, 9e-3, 8e-3, 7e-3, 6e-3})
    EXPECT_LT(periods_missed(pitch_m, 1.0, 500.0), 0.09) << pitch_m;
}

// The error falls within one period over the travel about the true pitch, and has other minima beyond. The
// search stays within, however many periods there are, and needs few evaluations.
TEST(ShapeSearch, APitchIsSearchedWithinItsMinimum) {
  const Measurement measurement(test::log_of(1000.0, 20'000, moves_m, [](double) { return 0.0; }));
  const std::vector<ShapeRange> ranges = searched_shapes(measurement, *find_effect("force_ripple"));
  for (const double true_m : {0.31, 0.1, 33e-3, 5e-3, 1.3e-3}) {
    int evaluations = 0;
    double farthest = 0.0;
    const auto off = [&](const std::vector<double>& shapes) { return 1.0 / shapes[0] - 1.0 / true_m; };
    const auto cost = [&](const std::vector<double>& shapes) {
      ++evaluations;
      farthest = std::max(farthest, std::abs(off(shapes)));
      const double phase = std::numbers::pi * off(shapes);
      return phase == 0.0 ? 0.1 : 1.1 - squared(std::sin(phase) / phase);
    };
    for (const double start : {-0.12, 0.05, 0.12}) {
      evaluations = 0;
      const SearchResult found = refine_shapes(ranges, {1.0 / (1.0 / true_m + start)}, cost, kFirstLook);
      EXPECT_LT(std::abs(off(found.shapes)), 0.01) << true_m << ' ' << start;
      EXPECT_LE(evaluations, 16) << true_m << ' ' << start;
    }
    EXPECT_LT(farthest, 0.5) << true_m;
  }
}

// As of the motor behind a gear of 1:100 over five turns.
TEST(ShapeSearch, BeginsAtAPitchOfWhichTheStrokeHasHundreds) {
  for (const double pitch_m : {2.5e-3, 1.6e-3, 1.25e-3, 1.03e-3})
    EXPECT_LT(periods_missed(pitch_m, 4.0, 1000.0), 0.09) << pitch_m;
}

/// The estimate of a drag with this exponent, beside so much viscous friction.
Term drag_found(double exponent, double viscous_N_s_per_m) {
  Log log = test::wandering_log(7, 1000.0, 20'000);
  Terms truth;
  {
    const Measurement measurement(log);
    truth = {make_term(measurement, *find_effect("viscous")),
             make_term(measurement, *find_effect("quadratic_drag"))};
    truth[0].gains = {viscous_N_s_per_m};
    truth[1].gains = {400.0};
    truth[1].shapes = {exponent};
    log.force_N = evaluate_force(measurement, truth).force_N;
  }
  test::Draw draw(3);
  for (double& force_N : log.force_N) force_N += 0.002 * draw.normal();
  const Measurement measurement(log);
  std::vector<std::string> effects{"offset_force", "quadratic_drag"};
  if (viscous_N_s_per_m > 0.0) effects.emplace_back("viscous");
  const FittedModel fitted = refine_nominal_shapes(measurement, fit_effects(measurement, effects, {}));
  return *find_term(with_standard_errors(measurement, fitted).terms, "quadratic_drag");
}

TEST(ShapeSearch, EstimatesTheExponentOfADrag) {
  for (const double exponent : {1.7, 2.3}) {
    const Term drag = drag_found(exponent, 0.0);
    EXPECT_NEAR(drag.shapes[0], exponent, 0.02);
    EXPECT_GT(drag.shape_standard_errors[0], 0.0);
    EXPECT_NEAR(drag.shapes[0], exponent, 5.0 * drag.shape_standard_errors[0]);
  }
}

TEST(ShapeSearch, KeepsTheNominalExponentBesideViscousFriction) {
  const Term drag = drag_found(2.0, 3.0);
  EXPECT_NEAR(drag.shapes[0], 2.0, 0.05);
  EXPECT_GE(drag.shapes[0], 2.0);
  EXPECT_NEAR(drag.gains[0], 400.0, 80.0);
}

/// The estimate of a lag, from a force recorded with so much noise.
Term lag_found(const MeasurementDynamics& lag, double noise_N, std::uint64_t seed) {
  Log log = test::wandering_log(seed, 2000.0, 30'000);
  {
    const Measurement measurement(log);
    Terms truth{make_term(measurement, *find_effect("viscous")),
                make_term(measurement, *find_effect("inertia"))};
    truth[0].gains = {8.0};
    truth[1].gains = {3.0};
    log.force_N = evaluate_force(measurement, truth).force_N;
  }
  sim::DelayLine recorder(1.0 / log.sample_rate_Hz, std::max(lag.delay_s, 0.0), lag.filter_s);
  for (double& force_N : log.force_N) force_N = recorder.push(force_N);
  // A lead: the force of later samples.
  const auto ahead =
      static_cast<std::ptrdiff_t>(std::round(std::max(-lag.delay_s, 0.0) * log.sample_rate_Hz));
  std::copy(log.force_N.begin() + ahead, log.force_N.end(), log.force_N.begin());
  log.force_N.resize(log.force_N.size() - static_cast<std::size_t>(ahead));
  log.position_m.resize(log.force_N.size());
  test::Draw draw(seed);
  for (double& force_N : log.force_N) force_N += noise_N * draw.normal();
  const Measurement measurement(log);
  const FittedModel fitted =
      refine_nominal_shapes(measurement, fit_effects(measurement, {"inertia", "viscous", "time_delay"}, {}));
  return *find_term(with_standard_errors(measurement, fitted).terms, "time_delay");
}

// Without viscous friction there is none that could differ between the directions, in a trial as in a fit.
TEST(ShapeSearch, KeepsAPartWithinTheEffectItIsAPartOf) {
  Log log = test::wandering_log(2, 2000.0, 20'000);
  for (std::size_t i = 1; i < log.force_N.size(); ++i)
    log.force_N[i] += 40.0 * std::abs(2000.0 * (log.position_m[i] - log.position_m[i - 1]));
  const Measurement measurement(log);
  const FittedModel base = fit_effects(measurement, {"presliding_hysteresis"}, {});
  const Trial trial = try_effect(measurement, base, *find_effect("direction_asymmetry"), {});
  EXPECT_EQ(trial.term.gains[2], 0.0);
}

// No delay does nothing: a search that began there alone would never be looked at among others.
TEST(ShapeSearch, BeginsTheSearchOfADelayWhereTheResidualShowsIt) {
  for (const double delay_s : {2e-3, -0.4e-3}) {
    Log prompt = test::wandering_log(3, 2000.0, 20'000, 0.0);
    Log late = prompt;
    for (std::size_t i = 0; i < prompt.force_N.size(); ++i) {
      const double t = static_cast<double>(i) / 2000.0;
      prompt.force_N[i] = 10.0 * std::sin(40.0 * t);
      late.force_N[i] = 10.0 * std::sin(40.0 * (t - delay_s));
    }
    const Measurement measurement(late);
    const Eigen::VectorXd residual_N = measurement.force_N() - Measurement(prompt).force_N();
    const auto starts =
        starting_shapes(measurement, *find_effect("time_delay"), residual_N, measurement.force_N());
    EXPECT_TRUE(std::any_of(starts.begin(), starts.end(), [&](const std::vector<double>& shapes) {
      return std::abs(shapes[0] - delay_s) < 0.05 * std::abs(delay_s);
    })) << delay_s;
    EXPECT_EQ(starts.front()[0], 0.0);
  }
}

TEST(ShapeSearch, KeepsAPureDelay) {
  for (const std::uint64_t seed : {21u, 22u, 23u}) {
    const Term lag = lag_found({2e-3, 0.0}, 0.05, seed);
    EXPECT_EQ(lag.shapes[1], 0.0);
    EXPECT_EQ(lag.shape_standard_errors[1], 0.0);
    EXPECT_NEAR(lag.lag_standard_error_s, lag.shape_standard_errors[0], 1e-3 * lag.shape_standard_errors[0]);
    EXPECT_NEAR(lag.shapes[0], 2e-3, 5.0 * lag.shape_standard_errors[0]);
  }
}

// A force that leads by 3 ms, through a low pass of 5 ms: whoever filters a force makes it late.
TEST(ShapeSearch, TakesNoLowPassBesideALeadForALag) {
  for (const std::uint64_t seed : {21u, 24u}) {
    const Term lag = lag_found({-8e-3, 5e-3}, 0.05, seed);
    EXPECT_EQ(lag.shapes[1], 0.0);
    EXPECT_NEAR(lag.shapes[0], -3e-3, 0.5e-3);
  }
}

// The noise that the inverse of the low pass amplifies does not bias its time constant.
TEST(ShapeSearch, SeparatesALowPassFromADelay) {
  for (const MeasurementDynamics lag : {MeasurementDynamics{0.0, 4e-3}, MeasurementDynamics{2e-3, 3e-3}}) {
    for (const double noise_N : {0.002, 0.05}) {
      const Term found = lag_found(lag, noise_N, 24);
      constexpr double kRamp_s = 1.5e-5;  // the recorder interpolates linearly between samples
      EXPECT_GT(found.shape_standard_errors[1], 0.0);
      EXPECT_NEAR(found.shapes[1], lag.filter_s, 4.0 * found.shape_standard_errors[1] + kRamp_s);
      EXPECT_NEAR(found.shapes[0], lag.delay_s, 4.0 * found.shape_standard_errors[0] + kRamp_s);
      EXPECT_NEAR(found.shapes[0] + found.shapes[1], lag.total_s(), 2e-4);
      EXPECT_NEAR(found.shapes[0] + found.shapes[1], lag.total_s(),
                  4.0 * found.lag_standard_error_s + kRamp_s);
      // One takes the place of the other, so that their sum is better known than either.
      EXPECT_GT(found.lag_standard_error_s, 0.0);
      EXPECT_LT(found.lag_standard_error_s, 0.5 * found.shape_standard_errors[0]);
      EXPECT_LT(found.shape_standard_errors[1], 0.25 * lag.filter_s);
    }
  }
}

TEST(ShapeSearch, FindsTheMinimumOfAQuadraticFunction) {
  const std::vector<ShapeRange> ranges{{0, 1e-4, 1.0, true}, {2, -2.0, 3.0, false}};
  int calls = 0;
  const auto cost = [&](const std::vector<double>& shapes) {
    ++calls;
    return 1.0 + std::pow(apart(ranges[0], shapes[0], 0.02), 2.0) +
           10.0 * std::pow(apart(ranges[1], shapes[2], -0.7), 2.0);
  };
  const SearchResult result = refine_shapes(ranges, {0.1, 42.0, 1.0}, cost, {80});
  EXPECT_NEAR(result.shapes[0] / 0.02, 1.0, 0.02);
  EXPECT_NEAR(result.shapes[2], -0.7, 0.05);
  EXPECT_EQ(result.shapes[1], 42.0);  // is not searched
  EXPECT_LE(calls, 82);
  EXPECT_EQ(result.cost, cost(result.shapes));
}

// A shape whose optimum lies beyond its bound ends at the bound, to the rounding of a logarithm.
TEST(ShapeSearch, StaysWithinItsBounds) {
  test::Draw draw(7);
  for (int trial = 0; trial < 200; ++trial) {
    const bool logarithmic = trial % 4 != 0;
    const auto lower = static_cast<double>(static_cast<float>(draw.log_uniform(1e-6, 1e-2)));
    const auto upper = static_cast<double>(static_cast<float>(lower * draw.log_uniform(2.0, 1e5)));
    const double sign = draw.sign();
    double lowest = upper;
    double highest = lower;
    const auto cost = [&](const std::vector<double>& shapes) {
      lowest = std::min(lowest, shapes[0]);
      highest = std::max(highest, shapes[0]);
      return 10.0 + sign * std::log(shapes[0]);
    };
    const SearchResult result =
        refine_shapes({{0, lower, upper, logarithmic}}, {0.5 * (lower + upper)}, cost, {60});
    EXPECT_GE(lowest, lower * (1.0 - 1e-14)) << trial;
    EXPECT_LE(highest, upper * (1.0 + 1e-14)) << trial;
    EXPECT_NEAR(result.shapes[0] / (sign > 0.0 ? lower : upper), 1.0, 0.05) << trial;
  }
}

TEST(ShapeSearch, SlipDistancesAreEvenInTheLogarithm) {
  const std::vector<double> slip = slip_distances(1e-7, 1e-3, 5, 8);
  ASSERT_EQ(slip.size(), 8u);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(slip[i], std::pow(10.0, -7.0 + static_cast<double>(i)), 1e-12);
  for (std::size_t i = 5; i < 8; ++i) EXPECT_EQ(slip[i], 0.0);
}

}  // namespace
}  // namespace slipstack::workbench
