// SPDX-License-Identifier: Apache-2.0
// What a search over several effects finds on random axes whose hidden effects mask each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "sim_host/log/draw.h"
#include "tests/unit/diagnose/diagnosed.h"
#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/diagnose/candidates.h"
#include "workbench/diagnose/search/elimination_and_exchange.h"
#include "workbench/diagnose/search/forward_selection.h"
#include "workbench/diagnose/search/steps.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

struct Result {
  std::vector<std::string> added;
  double error_over_floor;
};

Result found_on(std::uint64_t seed, const std::vector<sim::EffectId>& hidden) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  sim::add_effects(bench.axis, hidden, programme, bench.rate_Hz, 0.0, seed);
  const Diagnosis diagnosis = test::diagnosed(
      test::log_of(bench.axis, sim::simulate_log(bench.axis, programme, bench.rate_Hz, seed)));
  Result result{{}, diagnosis.explained.holdout_rmse_N / diagnosis.noise_floor_N};
  for (std::size_t i = 1; i < diagnosis.steps.size(); ++i) result.added.push_back(diagnosis.steps[i].effect);
  std::sort(result.added.begin(), result.added.end());
  return result;
}

// The viscous force is thirty times the noise. Alone, on top of the baseline, a lag of 4 % of the friction
// does nothing, and the shapes that fit there best mean nothing.
TEST(Search, FindsAnEffectThatALargerOneHides) {
  const Result found = found_on(2026117006, {sim::EffectId::kViscous, sim::EffectId::kFrictionalLag});
  EXPECT_EQ(found.added, (std::vector<std::string>{"frictional_lag", "viscous"}));
  EXPECT_LT(found.error_over_floor, 1.1);
}

// The friction falls by a third in proportion to time: an exponential that ends within its bounds is another
// curve, and what it leaves takes the form of a lag.
TEST(Search, ADriftInProportionToTimeIsADriftAlone) {
  const Result found = found_on(2026117009, {sim::EffectId::kMotorConstantRipple, sim::EffectId::kDrift});
  EXPECT_EQ(found.added, (std::vector<std::string>{"drift", "motor_constant_ripple"}));
  EXPECT_LT(found.error_over_floor, 1.1);
}

// Friction that falls with the velocity and follows it over the travel in which the hysteresis develops: to a
// lag alone that is the deflection of a bristle, however little it leaves. What is implausible alone is not
// told first.
TEST(Search, WhatIsImplausibleAloneIsNotToldFirst) {
  Log log = test::wandering_log(4, 2000.0, 40'000);
  {
    const Measurement motion(log);
    Terms truth{make_term(motion, *find_effect("presliding_hysteresis")),
                make_term(motion, *find_effect("frictional_lag"))};
    truth[0].shapes = {10e-6, 40e-6};
    truth[0].gains = {5e5, 1.25e5};
    truth[1].shapes = {10e-3, 2.0, 1e3, 60e-6};
    truth[1].gains = {0.5, 0.0};
    log.force_N = evaluate_force(motion, truth).force_N;
  }
  test::Draw draw(5);
  for (double& force_N : log.force_N) force_N += 0.02 * draw.normal();
  log.mass_kg = 0.0;
  Measurement measurement(log);
  weigh_rows(measurement);
  DiagnoseOptions options;
  options.baseline = {"presliding_hysteresis"};
  options.candidates = {"stribeck", "frictional_lag"};
  const FittedModel baseline = fit_effects(measurement, options.baseline, {});
  Found found = search(measurement, options, baseline);
  Terms both = baseline.terms;
  for (const char* id : {"frictional_lag", "stribeck"}) both.push_back(find_trial(found.alone, id)->term);
  found.best = {fit_gains(measurement, both, &baseline), {"frictional_lag", "stribeck"}};
  Diagnosis is;
  is.baseline = baseline;
  is.candidates = list_candidates(measurement, found);
  rank_candidates(is, found.best.added);
  ASSERT_EQ(is.candidates.front().term.id(), "frictional_lag")
      << "alone it leaves less than Stribeck friction";
  ASSERT_TRUE(is_implausible_alone(measurement, baseline, is.candidates.front()));
  ASSERT_FALSE(is_implausible_alone(measurement, baseline, is.candidates[1]));
  list_steps(found.context, found.best, is);
  ASSERT_EQ(is.steps.size(), 3u);
  EXPECT_EQ(is.steps[1].effect, "stribeck");
  EXPECT_EQ(is.steps[2].effect, "frictional_lag");
}

// Beside a delay friction follows the velocity late, as a lubricant film does. Neither Stribeck friction nor
// a delay alone is better than a lag.
TEST(Search, ADelayBesideStribeckFrictionIsNoLag) {
  constexpr std::uint64_t kSeed = 31;
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, kSeed);
  const sim::MotionProgramme programme = sim::draw_programme(bench, kSeed);
  sim::add_effects(bench.axis, {sim::EffectId::kStribeck}, programme, bench.rate_Hz, 0.0, kSeed);
  Log log = test::log_of(bench.axis, sim::simulate_log(bench.axis, programme, bench.rate_Hz, kSeed));
  const auto late = static_cast<std::ptrdiff_t>(std::lround(0.005 * log.sample_rate_Hz));
  std::rotate(log.force_N.begin(), log.force_N.end() - late, log.force_N.end());
  const Diagnosis diagnosis = test::diagnosed(log);
  std::vector<std::string> added;
  for (std::size_t i = 1; i < diagnosis.steps.size(); ++i) added.push_back(diagnosis.steps[i].effect);
  std::sort(added.begin(), added.end());
  EXPECT_EQ(added, (std::vector<std::string>{"stribeck", "time_delay"}));
}

/// The position of moves of fifth order to and fro, each within `move_s`, with as long a rest before it.
double moved_m(double time_s, double move_s) {
  const double cycle = time_s / (2.0 * move_s);
  const double number = std::floor(cycle);
  const double share = std::max(0.0, 2.0 * (cycle - number) - 1.0);
  const double from_m = 0.1 * std::sin(2.4 * number);
  const double to_m = 0.1 * std::sin(2.4 * (number + 1.0));
  return from_m + (to_m - from_m) * share * share * share * (10.0 + share * (6.0 * share - 15.0));
}

/// The log of a rigid axis of 1 kg with little friction, of Dahl's form, under a controller of 8 Hz that
/// reads an encoder with steps of `step_m`: position and velocity, without feed-forward.
Log log_under_control(double step_m, std::uint64_t seed) {
  constexpr double kTick_s = 1e-3;
  constexpr int kSubsteps = 20;
  constexpr double kBandwidth_radps = 50.0;
  test::Draw draw(seed);
  double x = 0.0;
  double v = 0.0;
  double friction_N = 0.0;
  double read_m = 0.0;
  double filtered_mps = 0.0;
  std::vector<double> position_m;
  std::vector<double> force_N;
  for (int tick = 0; tick < 30'000; ++tick) {
    const double time_s = tick * kTick_s;
    const double before_m = std::exchange(read_m, step_m * std::round(x / step_m));
    filtered_mps += 0.8 * ((read_m - before_m) / kTick_s - filtered_mps);
    const double force = kBandwidth_radps * kBandwidth_radps * (moved_m(time_s, 0.3) - read_m) -
                         1.4 * kBandwidth_radps * filtered_mps;
    position_m.push_back(read_m);
    force_N.push_back(force + 0.01 * draw.normal());
    for (int i = 0; i < kSubsteps; ++i) {
      constexpr double kLevel_N = 0.01;
      constexpr double kTravel_m = 20e-6;
      friction_N += (v - friction_N / kLevel_N * std::abs(v)) * kLevel_N / kTravel_m * kTick_s / kSubsteps;
      v += (force - friction_N) * kTick_s / kSubsteps;
      x += v * kTick_s / kSubsteps;
    }
  }
  Log log = test::log_of(
      1.0 / kTick_s, position_m.size(),
      [&](double t) { return position_m[static_cast<std::size_t>(std::lround(t / kTick_s))]; },
      [&](double t) { return force_N[static_cast<std::size_t>(std::lround(t / kTick_s))]; });
  log.mass_kg = 1.0;
  log.encoder_resolution_m = step_m;
  return log;
}

// The controller answers the steps of the encoder, and the force is then no noise beside them: a mode takes
// the form of the controller.
TEST(Search, NamesNoModeWhereAControllerAnswersTheEncoder) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Diagnosis diagnosis = test::diagnosed(log_under_control(16e-6, seed), {"structural_resonance"});
    EXPECT_EQ(diagnosis.steps.size(), 1u) << seed;
    ASSERT_FALSE(diagnosis.candidates.empty());
    EXPECT_GT(diagnosis.candidates.front().error_reduction, 0.05);  // it would lower the error
  }
}

// In a motion that repeats a force over the time since the load changed its sign is any curve, and one of
// viscous friction beside a bristle's is explained by it: less is left than by viscous friction, which alone
// explains nearly all.
TEST(Search, AMotionThatRepeatsIsNoGapWhereViscousFrictionExplainsNearlyAll) {
  constexpr double kTick_s = 5e-3;
  constexpr double kPeriod_s = 4.67;
  constexpr double kMass_kg = 0.35;
  constexpr double kViscous_N_s_per_m = 0.32;
  constexpr double kDevelops_m = 0.87e-3;  // the friction of 1 N, as in a model of Dahl
  constexpr double kEncoder_m = 0.767e-3;
  const auto quintic = [](double u) {
    const double within = std::clamp(u, 0.0, 1.0);
    return within * within * within * (10.0 - 15.0 * within + 6.0 * within * within);
  };
  const auto position_m = [&](double t) {
    const double u = std::fmod(t, kPeriod_s) / kPeriod_s;
    return 3.0 * (quintic(u / 0.35) - quintic((u - 0.5) / 0.35));
  };
  test::Draw draw(7);
  double bristle = 0.0;
  double before_m = position_m(0.0);
  Log log = test::log_of(1.0 / kTick_s, 9650, position_m, [&](double t) {
    for (int i = 9; i >= 0; --i) {
      const double x = position_m(std::max(0.0, t - 0.1 * i * kTick_s));
      const double side = x > before_m ? 1.0 : x < before_m ? -1.0 : 0.0;
      bristle = side + (bristle - side) * std::exp(-std::abs(x - before_m) / kDevelops_m);
      before_m = x;
    }
    const double ahead_m = position_m(t + 1e-3), behind_m = position_m(std::max(0.0, t - 1e-3));
    return kMass_kg * (ahead_m - 2.0 * position_m(t) + behind_m) / 1e-6 + bristle +
           kViscous_N_s_per_m * (ahead_m - behind_m) / 2e-3 + 0.007 * draw.normal();
  });
  for (double& x : log.position_m) x = std::round(x / kEncoder_m) * kEncoder_m;
  log.mass_kg = kMass_kg;
  log.encoder_resolution_m = kEncoder_m;
  const Diagnosis diagnosis = test::diagnosed(log);
  ASSERT_GE(diagnosis.steps.size(), 2u);
  EXPECT_EQ(diagnosis.steps[1].effect, "viscous");
}

/// What is left of viscous friction and a constant force, both of one gain, on a log with 5 N s/m and
/// `offset_N`.
std::vector<std::string> determined(double offset_N) {
  test::Draw draw(3);
  const auto x = [](double t) { return 0.02 * std::sin(6.0 * t) + 0.003 * std::sin(31.0 * t); };
  Log log = test::log_of(1000.0, 12000, x, [&](double t) {
    const double velocity_mps = 0.12 * std::cos(6.0 * t) + 0.093 * std::cos(31.0 * t);
    return 5.0 * velocity_mps + offset_N + 0.1 * draw.normal();
  });
  log.mass_kg = 0.0;
  Measurement measurement(log);
  weigh_rows(measurement);
  const FittedModel baseline = fit_effects(measurement, {"presliding_hysteresis"}, {});
  const SelectionContext context{measurement, baseline, Criterion(measurement, baseline.terms, 10)};
  Explanation explanation{{}, {"viscous", "offset_force"}};
  Terms terms = baseline.terms;
  for (const std::string& id : explanation.added) terms.push_back(make_term(measurement, *find_effect(id)));
  explanation.model = fit_gains(measurement, terms);
  drop_undetermined(context, explanation);
  return explanation.added;
}

TEST(DropUndetermined, WhatMayAsWellBeZeroBesideOthers) {
  EXPECT_EQ(determined(0.0), (std::vector<std::string>{"viscous"}));
  EXPECT_EQ(determined(0.5), (std::vector<std::string>{"viscous", "offset_force"}));
}

// Each of its two gains is within two standard errors of zero, since one can take the place of the other. Of
// a memory that decays with time no distance is known.
TEST(DropUndetermined, NoLagOfWhichTimeOrDistanceIsKnown) {
  const Measurement measurement(test::wandering_log(5, 1000.0, 20'000));
  Term lag = make_term(measurement, *find_effect("frictional_lag"));
  lag.shapes = {0.012, 1.5, 0.08, 0.8};
  lag.gains = {0.017, 0.016};
  lag.gain_standard_errors = {0.025, 0.022};
  const auto is_undetermined_with = [&](double time_error_s, double distance_error_m) {
    lag.shape_standard_errors = {0.002, 0.7, time_error_s, distance_error_m};
    return is_undetermined(measurement, {}, lag);
  };
  EXPECT_FALSE(is_undetermined_with(0.007, 4.3));
  EXPECT_FALSE(is_undetermined_with(0.4, 0.1));
  EXPECT_TRUE(is_undetermined_with(0.4, 4.3));
}

/// Whether an asymmetry of the level by `with_friction`, and by `with_motion` more once the axis moves, keeps
/// its name.
bool keeps_asymmetry(double with_friction, double with_motion) {
  Log log = test::wandering_log(5, 1000.0, 20'000);
  log.mass_kg = 0.0;
  Measurement measurement(log);
  Terms truth{make_term(measurement, *find_effect("coulomb")),
              make_term(measurement, *find_effect("direction_asymmetry"))};
  truth[0].gains = {10.0};
  truth[1].gains = {with_friction, with_motion, 0.0};
  const std::vector<double> force_N = evaluate_force(measurement, truth).force_N;
  test::Draw draw(6);
  for (std::size_t i = 0; i < force_N.size(); ++i) log.force_N[i] = force_N[i] + 0.05 * draw.normal();
  measurement = Measurement(log);
  weigh_rows(measurement);
  const FittedModel baseline = fit_gains(measurement, {truth[0]});
  const SelectionContext context{measurement, baseline, Criterion(measurement, baseline.terms, 10)};
  Explanation explanation{fit_gains(measurement, truth), {"direction_asymmetry"}};
  drop_undetermined(context, explanation);
  return !explanation.added.empty();
}

// In steady motion the friction is the same both ways where the gains cancel; half a per cent of the level is
// what a hysteresis of another form leaves.
TEST(DropUndetermined, AnAsymmetryOfWhichNothingIsLeftInSteadyMotion) {
  EXPECT_FALSE(keeps_asymmetry(0.3, -0.3));
  EXPECT_FALSE(keeps_asymmetry(0.3, -0.302));
  EXPECT_TRUE(keeps_asymmetry(0.3, -0.28));
  EXPECT_TRUE(keeps_asymmetry(0.0, 0.05));
}

}  // namespace
}  // namespace slipstack::workbench
