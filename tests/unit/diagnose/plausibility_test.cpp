// SPDX-License-Identifier: Apache-2.0
// What a fitted effect cannot be: a mode that does not ring, a lag of bristles, Coulomb friction within an
// encoder step.
#include "workbench/diagnose/evidence/plausibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/alternatives/cause_forms.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/implausible_causes.h"
#include "workbench/estimate/linear/force_trace.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// A model of hysteresis over about 20 um, with a lag.
FittedModel with_lag(const Measurement& measurement, double time_s, double distance_m) {
  FittedModel model;
  Term hysteresis = make_term(measurement, *find_effect("presliding_hysteresis"));
  std::fill(hysteresis.shapes.begin(), hysteresis.shapes.end(), 20e-6);
  std::fill(hysteresis.gains.begin(), hysteresis.gains.end(), 1e5);
  Term lag = make_term(measurement, *find_effect("frictional_lag"));
  lag.shapes = {0.01, 1.0, time_s, distance_m};
  model.terms = {hysteresis, lag};
  return model;
}

/// Whether Coulomb friction, saturated at 20 um/s, is of the sampling where an axis that turns round at 40
/// mm/s^2 has it and one stop operator, and the baseline the operator alone.
bool is_of_sampling(double slip_distance_m, double level_N, double coulomb_N) {
  constexpr double kSaturation_mps = 20e-6;  // a sample's change of velocity
  const auto x = [](double t) { return 1e-3 * std::cos(kTwoPi * t); };
  double last_m = x(0.0);
  double z_m = 0.0;
  const Log log = test::log_of(2000.0, 12000, x, [&](double t) {
    z_m = std::clamp(z_m + x(t) - last_m, -slip_distance_m, slip_distance_m);
    last_m = x(t);
    const double v = -kTwoPi * 1e-3 * std::sin(kTwoPi * t);
    return level_N * z_m / slip_distance_m + coulomb_N * std::clamp(v / kSaturation_mps, -1.0, 1.0);
  });
  const Measurement measurement(log);
  Term hysteresis = make_term(measurement, *find_effect("presliding_hysteresis"));
  std::fill(hysteresis.shapes.begin(), hysteresis.shapes.end(), 0.0);
  hysteresis.shapes.front() = slip_distance_m;
  Term coulomb = make_term(measurement, *find_effect("coulomb"));
  coulomb.shapes = {kSaturation_mps};
  const FittedModel baseline = fit_gains(measurement, {hysteresis});
  return coulomb_is_of_sampling(measurement, baseline, fit_gains(measurement, {hysteresis, coulomb}));
}

TEST(CoulombIsOfSampling, WhereItDiffersFromTheHysteresisWithinASampleOfReversals) {
  EXPECT_TRUE(is_of_sampling(1e-9, 0.0, 10.0));     // the operator slips within a sample
  EXPECT_FALSE(is_of_sampling(20e-6, 10.0, 10.0));  // it needs sixty samples
}

TEST(LagIsBristleDeflection, OverThePreSlidingTravelAndNotInTime) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  EXPECT_TRUE(lag_is_bristle_deflection(with_lag(measurement, 100.0, 30e-6)));
  EXPECT_FALSE(lag_is_bristle_deflection(with_lag(measurement, 100.0, 1e-3)));   // memory of a film
  EXPECT_FALSE(lag_is_bristle_deflection(with_lag(measurement, 0.002, 30e-6)));  // in time
  FittedModel none = with_lag(measurement, 100.0, 30e-6);
  none.terms.pop_back();
  EXPECT_FALSE(lag_is_bristle_deflection(none));
}

TEST(LagIsImmediate, ShorterThanAnyMemoryThatWasMeasured) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  EXPECT_TRUE(lag_is_immediate(measurement, with_lag(measurement, 0.7e-3, 100.0)));
  EXPECT_FALSE(lag_is_immediate(measurement, with_lag(measurement, 1.4e-3, 100.0)));
  EXPECT_TRUE(lag_is_immediate(measurement,
                               with_lag(measurement, 100.0, 7e-6)));  // at the Stribeck velocity, 10 mm/s
  EXPECT_FALSE(lag_is_immediate(measurement, with_lag(measurement, 100.0, 14e-6)));
  EXPECT_TRUE(lag_is_immediate(measurement, with_lag(measurement, 1.4e-3, 14e-6)));  // the two together
  const Measurement slow(test::wandering_log(1, 200.0, 6000));  // within a sample, which is 5 ms
  EXPECT_TRUE(lag_is_immediate(slow, with_lag(slow, 5.0e-3, 100.0)));
  EXPECT_FALSE(lag_is_immediate(slow, with_lag(slow, 5.1e-3, 100.0)));
}

/// A hysteresis whose level follows a map over the position, with `count` neighbouring splines at their
/// bound.
FittedModel with_map_at_bound(const Measurement& measurement, std::size_t count) {
  FittedModel model = with_lag(measurement, 1.0, 1.0);
  model.terms.back() = make_term(measurement, *find_effect("position_dependent_preload"));
  Term& map = model.terms.back();
  for (std::size_t i = 0; i < count; ++i) map.gains[8 + i] = map.lower[8 + i];
  return model;
}

TEST(IsImplausible, AMapByItsValuesAndNotByItsSplines) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  FittedModel baseline = with_map_at_bound(measurement, 0);
  baseline.terms.pop_back();
  // Of one spline at -95 % the map is -63 % where it is lowest; of four at their bound it is -95 %.
  EXPECT_FALSE(is_implausible(measurement, baseline, with_map_at_bound(measurement, 1)));
  EXPECT_TRUE(is_implausible(measurement, baseline, with_map_at_bound(measurement, 4)));
}

TEST(LagIsChangeOverTime, LongerThanAnyMemoryThatWasMeasured) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  EXPECT_TRUE(lag_is_change_over_time(measurement, with_lag(measurement, 16.0, 100.0)));
  EXPECT_FALSE(lag_is_change_over_time(measurement, with_lag(measurement, 0.3, 100.0)));  // of a film
  EXPECT_FALSE(lag_is_change_over_time(measurement, with_lag(measurement, 16.0, 1e-3)));  // over a distance
}

/// Hysteresis of 16 N with Coulomb friction.
FittedModel with_coulomb(const Measurement& measurement, double coulomb_N) {
  FittedModel model = with_lag(measurement, 1.0, 1e-3);
  Term& hysteresis = model.terms.front();
  hysteresis.gains.assign(hysteresis.gains.size(), 0.0);
  hysteresis.gains.front() = 16.0 / hysteresis.shapes.front();
  model.terms.back() = make_term(measurement, *find_effect("coulomb"));
  model.terms.back().gains = {coulomb_N};
  return model;
}

TEST(CoulombIsOfHysteresis, BelowATenthOfTheDryFrictionOrFarAboveTheFloor) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  EXPECT_TRUE(coulomb_is_of_hysteresis(with_coulomb(measurement, 1.6), 1.0));
  EXPECT_FALSE(coulomb_is_of_hysteresis(with_coulomb(measurement, 2.0), 1.0));
  FittedModel poor = with_coulomb(measurement, 2.0);
  poor.holdout_rmse_N = 1.64;
  EXPECT_FALSE(coulomb_is_of_hysteresis(poor, 1.0));
  poor.holdout_rmse_N = 1.66;
  EXPECT_TRUE(coulomb_is_of_hysteresis(poor, 1.0));
  poor.terms.pop_back();
  EXPECT_FALSE(coulomb_is_of_hysteresis(poor, 1.0));
}

/// A fitted mass of 2 kg with an arm of `modal_kg` on it.
FittedModel with_arm(const Measurement& measurement, double modal_kg) {
  FittedModel model;
  Term inertia = make_term(measurement, *find_effect("inertia"));
  inertia.gains = {2.0};
  Term mode = make_term(measurement, *find_effect("structural_resonance"));
  mode.shapes = {30.0, 0.02};
  mode.gains = {modal_kg, 0.0, 0.0};
  model.terms = {inertia, mode};
  return model;
}

TEST(IsTooSmall, AnEffectThatGrowsWithAForceOfWhichItIsAPerMille) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  FittedModel baseline = with_arm(measurement, 0.3);
  baseline.terms.pop_back();
  baseline.train_rmse_N = 1.0;
  baseline.relative_error = 0.01;  // a force of 100 N
  Terms payload = baseline.terms;
  payload.push_back(make_term(measurement, *find_effect("payload_mass")));
  EXPECT_TRUE(is_too_small(measurement, baseline, baseline.terms, payload, 0.009));
  EXPECT_FALSE(is_too_small(measurement, baseline, baseline.terms, payload, 0.011));
  Terms viscous = baseline.terms;
  viscous.push_back(make_term(measurement, *find_effect("viscous")));
  EXPECT_FALSE(is_too_small(measurement, baseline, baseline.terms, viscous, 0.009));
}

TEST(IsTooSmall, AModeThatSmoothsTheRoundingOfTheEncoder) {
  Log log = test::wandering_log(1, 2000.0, 6000);
  log.encoder_resolution_m = 5e-6;
  const Measurement measurement(log);
  const Term inertia = with_arm(measurement, 0.3).terms.front();
  const double axis_kg = mass_kg({inertia});
  // A third of the axis swings, with no mass beside: far above its frequency two thirds follow.
  Term mode = make_term(measurement, *find_effect("structural_resonance"));
  mode.shapes = {2.0, 0.02};  // so low that the rounding of the motion is no question
  mode.gains = {axis_kg / 3.0, 0.0, -axis_kg / 3.0};
  const Terms after{inertia, mode};
  const Terms before{inertia};
  ASSERT_EQ(measurement.parts().size(), 1u);
  // Where the axis moves over many steps in each sample its rounding is white (Bennett 1948).
  const double white_N2 = squared(axis_kg * measurement.acceleration_noise_mps2(measurement.parts().front()));
  const double smoothed_N2 = smoothed_rounding_N2(measurement, before, after);
  EXPECT_GT(smoothed_N2, 0.5 * 5.0 / 9.0 * white_N2);
  EXPECT_LT(smoothed_N2, 2.0 * 5.0 / 9.0 * white_N2);
  EXPECT_EQ(smoothed_rounding_N2(measurement, after, before), 0.0);  // no mode that smooths
  FittedModel baseline;
  baseline.terms = {inertia};
  EXPECT_TRUE(is_too_small(measurement, baseline, before, after, 3.9 * smoothed_N2));
  EXPECT_FALSE(is_too_small(measurement, baseline, before, after, 4.1 * smoothed_N2));
  // Beside a mode that is known it is no question.
  EXPECT_FALSE(is_too_small(measurement, baseline, after, after, 0.1 * smoothed_N2));
  log.encoder_resolution_m = 0.0;
  EXPECT_EQ(smoothed_rounding_N2(Measurement(log), before, after), 0.0);
}

/// Moves at irregular intervals, which excite a mode anew, each with a phase of its own.
double moved_m(double time_s) {
  double position_m = 0.0;
  for (int move = 0; move < 8; ++move) {
    const double share = std::clamp((time_s - 0.7 * move - 0.2 * std::sin(5.0 * move)) / 0.15, 0.0, 1.0);
    const double way_m = move % 2 == 0 ? 0.02 : -0.02;
    position_m += way_m * share * share * share * (10.0 + share * (6.0 * share - 15.0));
  }
  return position_m;
}

// Beside viscous friction that no model has; the mass is free, so that it is the payload.
TEST(HasImplausibleMode, AtTheEndOfTheBandUnlessItExplainsMostOfWhatAPayloadLeaves) {
  Log log = test::log_of(200.0, 1200, moved_m, [](double) { return 0.0; });  // a band of 20 Hz
  log.encoder_resolution_m = 1e-9;
  const Measurement empty(log);
  Terms truth = with_arm(empty, 0.5).terms;
  truth.back().shapes = {searched_shapes(empty, *truth.back().effect).front().upper, 0.02};
  const std::vector<double> of_mode_N = evaluate_force(empty, truth).force_N;
  const auto left_N2 = [&](double viscous_Ns_per_m, bool with_mode) {
    for (std::size_t i = 0; i < log.force_N.size(); ++i)
      log.force_N[i] = of_mode_N[i] + viscous_Ns_per_m * empty.velocity_mps()[i];
    const Measurement measurement(log);
    return squared(fit_gains(measurement, with_mode ? truth : Terms{truth.front()}).holdout_rmse_N);
  };
  const double swings_N2 = left_N2(0.0, false);
  ASSERT_LT(left_N2(0.0, true), 1e-3 * swings_N2);
  const double viscous_Ns_per_m = std::sqrt(swings_N2 / left_N2(1.0, true));
  double floor_N2 = 0.0;
  const auto is_none = [&](double share) {
    static_cast<void>(left_N2(std::sqrt(share) * viscous_Ns_per_m, true));
    Measurement measurement(log);
    measurement.set_noise_variance(Eigen::VectorXd::Constant(measurement.row_count(), floor_N2));
    return has_implausible_mode(measurement, fit_gains(measurement, {truth.front()}),
                                fit_gains(measurement, truth));
  };
  EXPECT_FALSE(is_none(0.7));
  EXPECT_TRUE(is_none(1.4));
  floor_N2 = swings_N2;  // of which no model explains anything
  EXPECT_FALSE(is_none(1.4));
}

// Above the band a mode is a phase, as is a rest of a delay.
TEST(HasImplausibleMode, AtTheEndOfTheBandBesideADelay) {
  Log log = test::log_of(200.0, 1200, moved_m, [](double) { return 0.0; });
  log.encoder_resolution_m = 1e-9;
  const Measurement empty(log);
  Terms truth = with_arm(empty, 0.5).terms;
  truth.back().shapes = {searched_shapes(empty, *truth.back().effect).front().upper, 0.02};
  log.force_N = evaluate_force(empty, truth).force_N;
  Measurement measurement(log);
  measurement.set_noise_variance(Eigen::VectorXd::Zero(measurement.row_count()));
  const FittedModel rigid = fit_gains(measurement, {truth.front()});
  EXPECT_FALSE(has_implausible_mode(measurement, rigid, fit_gains(measurement, truth)));
  truth.push_back(make_term(measurement, *find_effect("time_delay")));
  EXPECT_TRUE(has_implausible_mode(measurement, rigid, fit_gains(measurement, truth)));
}

TEST(HasImplausibleMode, ThatMovesTheAxisByNoMoreThanTheEncoderRounds) {
  Log log = test::log_of(2000.0, 12'000, moved_m, [](double) { return 0.0; });
  log.encoder_resolution_m = 5e-6;
  const Measurement empty(log);
  const auto is_none = [&](double share_of_rounding) {
    Terms truth = with_arm(empty, 0.01).terms;
    truth.back().shapes = {8.0, 0.1};
    // 5 um are rounded by 1.443 um rms; at 8 Hz that is an acceleration of 3.647 mm/s2.
    const double rounding_N = 3.647e-3 * 2.0;
    EXPECT_NEAR(std::sqrt(rounded_motion_N2(empty, truth)), rounding_N, 0.01 * rounding_N);
    const auto swing_N = [&] {
      const Eigen::VectorXd force_N = at_rows(empty, evaluate_force(empty, {truth.back()}).force_N);
      const Eigen::VectorXd acceleration_mps2 = at_rows(empty, empty.acceleration_mps2());
      const double along = force_N.dot(acceleration_mps2) / acceleration_mps2.squaredNorm();
      return std::sqrt((force_N - along * acceleration_mps2).array().square().mean());
    };
    truth.back().gains[0] *= share_of_rounding * rounding_N / swing_N();
    log.force_N = evaluate_force(empty, truth).force_N;
    const Measurement measurement(log);
    const FittedModel baseline = fit_gains(measurement, {truth.front()});
    const FittedModel model = fit_gains(measurement, truth);
    return has_implausible_mode(measurement, baseline, model);
  };
  EXPECT_TRUE(is_none(0.9));
  EXPECT_FALSE(is_none(1.1));
}

// A heavy arm on an axis whose encoder is so coarse that what swings moves it by less than it rounds.
TEST(HasImplausibleMode, WithinTheRoundingUnlessAPayloadShowsItsMass) {
  constexpr double kStep_m = 1e-3;
  Log log = test::log_of(2000.0, 12'000, moved_m, [](double) { return 0.0; });
  const Measurement exact(log);
  for (double& x : log.position_m) x = std::round(x / kStep_m) * kStep_m;
  log.encoder_resolution_m = kStep_m;
  Terms arm = with_arm(exact, 0.5).terms;
  arm.back().shapes = {18.0, 0.02};
  arm.front().lower = arm.front().upper = arm.front().gains;  // a declared mass
  Terms payload{arm.front(), make_term(exact, *find_effect("payload_mass"))};
  payload.back().gains.front() = arm.back().gains.front();
  const auto is_none = [&](const Terms& truth) {
    log.force_N = evaluate_force(exact, truth).force_N;
    const Measurement measurement(log, {.bandwidth_Hz = 20.0});
    const FittedModel baseline = fit_gains(measurement, {arm.front()});
    const FittedModel model = fit_gains(measurement, arm);
    EXPECT_GT(baseline.holdout_rmse_N, 2.0 * model.holdout_rmse_N);
    EXPECT_LT(model.holdout_rmse_N, fit_gains(measurement, payload).holdout_rmse_N);
    return has_implausible_mode(measurement, baseline, model);
  };
  EXPECT_FALSE(is_none(arm));
  // A payload of the same mass, which a mode explains as well, and some of the rounding.
  EXPECT_TRUE(is_none(payload));
}

TEST(IsTooSmall, AnEffectBesideHysteresisThatIsHalfAPerCentOfItsLevelUnlessItRepeats) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  FittedModel baseline = with_lag(measurement, 0.0, 1e-3);
  baseline.terms.pop_back();
  baseline.train_rmse_N = 0.1;
  baseline.relative_error = 0.01;  // a force of 10 N
  const double level_N = hysteresis_level_N(baseline.terms.front());
  const auto is_small = [&](const char* id, const Terms& before, double share_of_level) {
    Terms after = before;
    after.push_back(make_term(measurement, *find_effect(id)));
    const double step_N = share_of_level * level_N;
    return is_too_small(measurement, baseline, before, after, step_N * step_N);
  };
  for (const char* id : {"viscous", "coulomb", "offset_force", "structural_resonance", "drift"}) {
    EXPECT_TRUE(is_small(id, baseline.terms, 0.0049)) << id;
    EXPECT_FALSE(is_small(id, baseline.terms, 0.0051)) << id;
    EXPECT_FALSE(is_small(id, {}, 0.0049)) << id << ", without hysteresis";
  }
  for (const char* id : {"force_ripple", "motor_constant_ripple"}) {
    EXPECT_FALSE(is_small(id, baseline.terms, 0.0005)) << id;
  }
  // Of two logs with levels of their own it is the mean.
  Terms two = baseline.terms;
  two.front().gains.insert(two.front().gains.end(), two.front().gains.begin(), two.front().gains.end());
  EXPECT_TRUE(is_small("viscous", two, 0.0049));
  EXPECT_FALSE(is_small("viscous", two, 0.0051));
}

/// A model without anything but this effect.
FittedModel with_only(Term term) {
  FittedModel model;
  model.terms = {std::move(term)};
  return model;
}

TEST(IsImplausible, WithAGainAtABoundOtherThanZero) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  Term weakening = make_term(measurement, *find_effect("stribeck"));
  weakening.gains = {0.5, 0.0};
  EXPECT_FALSE(is_implausible(measurement, {}, with_only(weakening)));
  weakening.gains[0] = weakening.upper[0];
  EXPECT_TRUE(is_implausible(measurement, {}, with_only(weakening)));
  // What the baseline has, the search did not find.
  EXPECT_FALSE(is_implausible(measurement, with_only(weakening), with_only(weakening)));
  weakening.lower[0] = weakening.upper[0];  // given, not fitted
  EXPECT_FALSE(is_implausible(measurement, {}, with_only(weakening)));
}

TEST(IsImplausible, WhereFrictionIsTakenAwayOrMultiplied) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  Term weakening = make_term(measurement, *find_effect("stribeck"));
  weakening.gains = {1.4, 1.4};  // 3.8 times at rest
  EXPECT_FALSE(is_implausible(measurement, {}, with_only(weakening)));
  weakening.gains = {2.0, 2.0};
  EXPECT_TRUE(is_implausible(measurement, {}, with_only(weakening)));
  Term map = make_term(measurement, *find_effect("position_dependent_preload"));
  map.gains.assign(map.gains.size(), -0.74);  // a factor of 3.8 down
  EXPECT_FALSE(is_implausible(measurement, {}, with_only(map)));
  map.gains.assign(map.gains.size(), -0.76);  // a factor of 4.2
  EXPECT_TRUE(is_implausible(measurement, {}, with_only(map)));
  EXPECT_FALSE(is_implausible(measurement, with_only(map), with_only(map)));
  map.lower.assign(map.gains.size(), -3.0);
  map.gains.assign(map.gains.size(), -1.1);
  EXPECT_TRUE(is_implausible(measurement, {}, with_only(map)));
}

// Each gain alone leaves half of the friction; what the sign of the friction adds counts too.
TEST(IsImplausible, WhereFrictionOfOneDirectionIsTakenAway) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  FittedModel model = with_lag(measurement, 1.0, 1e-3);
  model.terms.back() = make_term(measurement, *find_effect("direction_asymmetry"));
  model.terms.back().gains = {-0.2, -0.2, 0.0};
  EXPECT_FALSE(is_implausible(measurement, {}, model));
  model.terms.back().gains = {-0.45, -0.45, 0.0};  // 0.1 and 1.9 times
  EXPECT_TRUE(is_implausible(measurement, {}, model));
}

TEST(IsImplausible, WithAGainAtThatOfTheEffectItIsAPartOf) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  FittedModel model = with_only(make_term(measurement, *find_effect("viscous")));
  model.terms.front().gains = {5.0};
  model.terms.push_back(make_term(measurement, *find_effect("direction_asymmetry")));
  model.terms.back().gains = {0.1, 0.0, -4.9};
  EXPECT_FALSE(is_implausible(measurement, {}, model));
  model.terms.back().gains[2] = -5.0;
  EXPECT_TRUE(is_implausible(measurement, {}, model));
}

/// Modes are searched somewhat beyond the band.
double most_Hz(const Measurement& measurement) {
  return 1.2 * measurement.bandwidth_Hz();
}

TEST(IsImplausible, WithAModeAtTheEndOfItsSearch) {
  Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  measurement.set_noise_variance(Eigen::VectorXd::Zero(measurement.row_count()));
  FittedModel model = with_arm(measurement, 0.3);
  model.holdout_rmse_N = 100.0;  // it explains nothing
  model.terms.back().shapes[0] = 0.99 * most_Hz(measurement);
  EXPECT_FALSE(has_implausible_mode(measurement, {}, model));
  model.terms.back().shapes[0] = most_Hz(measurement);
  EXPECT_TRUE(has_implausible_mode(measurement, {}, model));
  EXPECT_TRUE(is_implausible(measurement, {}, model));
  EXPECT_FALSE(has_implausible_mode(measurement, model, model));  // the baseline has it
}

// A search by logarithms ends beside the bound by the last digits.
TEST(IsImplausible, WithAModeAtEitherEndOfItsSearchButForRounding) {
  Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  measurement.set_noise_variance(Eigen::VectorXd::Zero(measurement.row_count()));
  FittedModel model = with_arm(measurement, 0.3);
  model.holdout_rmse_N = 100.0;  // it explains nothing
  model.terms.back().shapes[0] = std::exp(std::log(most_Hz(measurement)) - 1e-12);
  EXPECT_TRUE(has_implausible_mode(measurement, {}, model));
  const double least_Hz = 4.0 / 3.0;  // four periods in the log
  model.terms.back().shapes = {1.01 * least_Hz, 0.1};
  EXPECT_FALSE(has_implausible_mode(measurement, {}, model));
  model.terms.back().shapes[0] = std::exp(std::log(least_Hz) + 1e-12);
  EXPECT_TRUE(has_implausible_mode(measurement, {}, model));
}

// Of a mode whose amplitude falls by less than to 1/e within the log of three seconds, no decay is seen.
TEST(IsImplausible, WithAModeThatDoesNotDecayWithinTheLog) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  FittedModel model = with_arm(measurement, 0.3);
  const double frequency_Hz = 0.5 * measurement.bandwidth_Hz();
  const double least = 1.0 / (kTwoPi * frequency_Hz * 3.0);
  model.terms.back().shapes = {frequency_Hz, 1.1 * least};
  EXPECT_FALSE(has_implausible_mode(measurement, {}, model));
  model.terms.back().shapes[1] = 0.9 * least;
  EXPECT_TRUE(has_implausible_mode(measurement, {}, model));
}

/// The mode of an axis that hums at 25 Hz by `hum_N` and has an arm of a tenth of its mass with its mode
/// there.
bool mode_is_implausible(double hum_N, double arm_share) {
  constexpr double kFrequency_Hz = 25.0;
  constexpr double kMass_kg = 10.0;
  constexpr double kSampled_Hz = 2000.0;
  const double omega = kTwoPi * kFrequency_Hz;
  test::Draw draw(4);
  Log log = test::wandering_log(2, kSampled_Hz, 40'000);
  // Blows every 0.7 s swing the arm; the hum shakes the axis.
  const auto blow = [](double t) {
    const double since = std::fmod(t, 0.7);
    return since < 0.02 ? 1e-5 * std::pow(std::sin(kTwoPi * since / 0.04), 2) : 0.0;
  };
  const auto hum_m = [&](double t) { return hum_N / (kMass_kg * omega * omega) * std::sin(omega * t); };
  for (std::size_t i = 0; i < log.position_m.size(); ++i) {
    const double t = static_cast<double>(i) / kSampled_Hz;
    log.position_m[i] += blow(t) + hum_m(t);
  }
  double q = 0.0, rate = 0.0;
  for (std::size_t i = 1; i + 1 < log.position_m.size(); ++i) {
    const double a =
        (log.position_m[i + 1] - 2.0 * log.position_m[i] + log.position_m[i - 1]) * kSampled_Hz * kSampled_Hz;
    rate += (a - 2.0 * 0.02 * omega * rate - omega * omega * q) / kSampled_Hz;
    q += rate / kSampled_Hz;
    const double t = static_cast<double>(i) / kSampled_Hz;
    log.force_N[i] = kMass_kg * a + arm_share * kMass_kg * (omega * omega * q - a) +
                     hum_N * std::cos(omega * t) + 0.01 * draw.normal();
  }
  log.mass_kg = kMass_kg;
  const Measurement measurement(log);
  const FittedModel baseline = fit_gains(measurement, {term_for_log(measurement, *find_effect("inertia"))});
  Terms terms = baseline.terms;
  terms.push_back(make_term(measurement, *find_effect("structural_resonance")));
  terms.back().shapes = {kFrequency_Hz, 0.02};
  return has_implausible_mode(measurement, baseline, fit_gains(measurement, terms));
}

// A lightly damped mode amplifies the trembling of the axis under a line in time, of one phase throughout.
TEST(IsImplausible, WithAModeThatIsALineInTime) {
  EXPECT_TRUE(mode_is_implausible(3.0, 0.0));
  EXPECT_FALSE(mode_is_implausible(0.0, 0.1));
}

// A pitch that wants to be longer than half the travel does not repeat; one turn of a rotary axis need not.
TEST(IsImplausible, WithAPitchOrDelayAtAnEndOfItsSearch) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  for (const char* const id : {"force_ripple", "time_delay"}) {
    Term term = make_term(measurement, *find_effect(id));
    const auto ranges = [&] {
      std::vector<ShapeRange> all = searched_shapes(measurement, *term.effect);
      return all.empty() ? nominal_shapes(measurement, *term.effect) : all;
    }();
    const ShapeRange& range = ranges.front();
    term.shapes[range.index] = 0.5 * (range.lower + range.upper);
    EXPECT_FALSE(has_shape_at_bound(measurement, {}, with_only(term))) << id;
    term.shapes[range.index] = range.upper;
    EXPECT_TRUE(has_shape_at_bound(measurement, {}, with_only(term))) << id;
    EXPECT_FALSE(has_shape_at_bound(measurement, with_only(term), with_only(term))) << id;
  }
}

TEST(HasOneRippleTwice, WhereTheTravelDoesNotTellThePitches) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  const auto [low, high] =
      std::minmax_element(measurement.position_m().begin(), measurement.position_m().end());
  const double travel_m = *high - *low;
  Terms terms{make_term(measurement, *find_effect("force_ripple"))};
  terms.front().shapes = {travel_m / 6.0};
  EXPECT_FALSE(has_one_ripple_twice(measurement, terms));
  terms.push_back(make_term(measurement, cause_of(CauseForm::second_ripple)));
  for (const double periods : {4.9, 7.1, 12.0}) {
    terms.back().shapes = {travel_m / periods};
    EXPECT_FALSE(has_one_ripple_twice(measurement, terms)) << periods;
  }
  for (const double periods : {5.1, 6.0, 6.9}) {
    terms.back().shapes = {travel_m / periods};
    EXPECT_TRUE(has_one_ripple_twice(measurement, terms)) << periods;
  }
  EXPECT_FALSE(lacks_supplemented(terms));
  EXPECT_TRUE(lacks_supplemented({terms.back()}));
}

// Hysteresis of 16 N; the gap's friction is its mass times its deceleration.
TEST(IsImplausible, WithAGapThatHasLessThanHalfOfTheFrictionBehindIt) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  FittedModel model = with_coulomb(measurement, 2.0);
  const auto causes = causes_to_try(measurement, {});
  const auto gap = std::find_if(causes.begin(), causes.end(), [](const EffectDescription* cause) {
    return form_of(*cause) == CauseForm::gap_in_drive;
  });
  ASSERT_NE(gap, causes.end());
  Term mass = make_term(measurement, *find_effect("inertia"));
  mass.gains = {6.0};
  model.terms.back() = mass;
  model.terms.push_back(make_term(measurement, **gap));
  model.terms.back().shapes = {40e-6, 2.0, 10e-6};
  model.terms.back().gains = {4.1};
  EXPECT_FALSE(is_implausible(measurement, {}, model));
  model.terms.back().gains = {3.9};
  EXPECT_TRUE(is_implausible(measurement, {}, model));
  model.terms.back().gains = {8.9};
  EXPECT_FALSE(is_implausible(measurement, {}, model));
  model.terms.back().gains = {9.1};  // of an axis of 6 kg, as far as a gap tells it
  EXPECT_TRUE(is_implausible(measurement, {}, model));
}

// Hysteresis of 16 N.
TEST(IsImplausible, WithABristleOfLessThanHalfOfTheFrictionOrOfWhatIsLeft) {
  Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  weigh_rows(measurement);
  FittedModel model = with_coulomb(measurement, 2.0);
  model.terms.back() = make_term(measurement, cause_of(CauseForm::bristle));
  model.terms.back().shapes = {10e-6};
  model.terms.back().gains = {16.1};
  EXPECT_FALSE(is_implausible(measurement, {}, model));
  model.terms.back().gains = {15.9};
  EXPECT_TRUE(is_implausible(measurement, {}, model));
  model.terms.back().gains = {16.1};
  const double floor_N2 = squared(measurement.noise_floor_N());
  const FittedModel other = fit_gains(measurement, {model.terms.front()}, &model);
  const double left_N2 = squared(other.holdout_rmse_N) - floor_N2;
  model.holdout_rmse_N = std::sqrt(floor_N2 + 0.49 * left_N2);
  EXPECT_FALSE(is_implausible(measurement, {}, model));
  model.holdout_rmse_N = std::sqrt(floor_N2 + 0.51 * left_N2);
  EXPECT_TRUE(is_implausible(measurement, {}, model));
}

TEST(HasNoTrueMode, WhereMostOfAFittedMassSwings) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  EXPECT_FALSE(has_no_true_mode(with_arm(measurement, 0.3).terms));
  EXPECT_FALSE(has_no_true_mode(with_arm(measurement, 29.4).terms));  // of an axis of 2 kg
  EXPECT_TRUE(has_no_true_mode(with_arm(measurement, 30.6).terms));
}

// A passive structure adds to the mass at its driving point in every mode.
TEST(HasNoTrueMode, WhereAMassBelowZeroSwings) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  FittedModel model = with_arm(measurement, 0.3);
  Term& mode = model.terms.back();
  mode.gains = {0.3, 0.0, 0.0, 0.2, 0.0, 0.0};  // of two logs
  EXPECT_FALSE(has_no_true_mode(model.terms));
  mode.gains[3] = -0.2;
  EXPECT_TRUE(has_no_true_mode(model.terms));
  EXPECT_TRUE(has_no_true_mode(with_arm(measurement, -0.3).terms));
}

// Behind the last sample nobody knows where the axis goes: an acceleration there is none that was fitted.
TEST(ChangesOfFriction, AreJudgedWhereTheFitLooks) {
  Log log = test::log_of(
      1000.0, 8000, [](double t) { return 0.02 * std::sin(6.0 * t); },
      [](double t) { return std::sin(6.0 * t); });
  const auto is_plausible = [](const Log& one, double pitching) {
    const Measurement measurement(one);
    FittedModel baseline;
    baseline.terms = {make_term(measurement, *find_effect("presliding_hysteresis"))};
    FittedModel model = baseline;
    Term preload = make_term(measurement, *find_effect("acceleration_dependent_preload"));
    preload.shapes = {1e3};
    preload.gains = {pitching, 0.0};
    model.terms.push_back(preload);
    return !is_implausible(measurement, baseline, model);
  };
  EXPECT_TRUE(is_plausible(log, 1.0));   // at 0.72 m/s^2: a factor of 1.7
  EXPECT_FALSE(is_plausible(log, 5.0));  // of 4.6
  log.position_m.back() += 50e-6;        // 50 m/s^2
  EXPECT_TRUE(is_plausible(log, 1.0));
  EXPECT_FALSE(is_plausible(log, 5.0));
}

}  // namespace
}  // namespace slipstack::workbench
