// SPDX-License-Identifier: Apache-2.0
// The effects that a log can show depend on the motion in it.
#include "workbench/diagnose/detectability/detectability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// Long fast traverses, with slow ones between them where `slow`; friction of one level.
Measurement traverses(bool slow) {
  test::Draw draw(6);
  const auto position_m = [slow](double t_s) {
    const double calm_s = 42.0 * std::numbers::pi / 9.0;  // the axis is where it began
    return slow && t_s > calm_s ? 2e-3 * std::sin(t_s - calm_s) : 0.08 * std::sin(9.0 * t_s);
  };
  Log log = test::log_of(1000.0, 30'000, position_m, [](double) { return 0.0; });
  for (std::size_t i = 1; i < log.force_N.size(); ++i) {
    const double velocity_mps = (log.position_m[i] - log.position_m[i - 1]) * 1000.0;
    log.force_N[i] = 4.0 * std::tanh(velocity_mps / 1e-4) + 0.05 * draw.normal();
  }
  return Measurement(log);
}

Visibility of_effect(const Measurement& measurement, const char* id, double shape) {
  const FittedModel base = fit_gains(measurement, {make_term(measurement, *find_effect("inertia")),
                                                   make_term(measurement, *find_effect("coulomb"))});
  Term term = make_term(measurement, *find_effect(id));
  if (!term.shapes.empty()) term.shapes[0] = shape;
  return visibility_of(measurement, base, baseline_residual_maker(measurement, base), term, 0.03);
}

TEST(Visibility, OfStribeckNeedsSlowMotion) {
  const Visibility fast = of_effect(traverses(false), "stribeck", 3e-3);
  const Visibility both = of_effect(traverses(true), "stribeck", 3e-3);
  EXPECT_GT(both.share, 0.2);
  EXPECT_LT(both.least_N, 0.2);
  EXPECT_GT(fast.least_N, 1.5 * both.least_N);
}

// A payload beside a free mass has the same column: no log can separate them.
TEST(Visibility, OfAColumnOfTheBaselineIsZero) {
  const Visibility payload = of_effect(traverses(true), "payload_mass", 0.0);
  EXPECT_LT(payload.share, 1e-6);
  EXPECT_GT(payload.least_N, 100.0);
}

TEST(Visibility, OfAnOrthogonalForceIsOne) {
  const Visibility offset = of_effect(traverses(true), "offset_force", 0.0);
  EXPECT_GT(offset.share, 0.9);
  // A constant of this rms raises the error by the reduction that is demanded of an effect.
  const Measurement measurement = traverses(true);
  const FittedModel base = fit_gains(measurement, {make_term(measurement, *find_effect("inertia")),
                                                   make_term(measurement, *find_effect("coulomb"))});
  // Its peak is its rms.
  const double with_it = std::hypot(base.holdout_rmse_N, offset.least_N * std::sqrt(offset.share));
  EXPECT_NEAR(base.holdout_rmse_N / with_it, 0.97, 1e-9);
}

// However little noise there is: hysteresis of another form would leave as much.
TEST(Visibility, BesideHysteresisHasALeastShareOfItsLevel) {
  constexpr double kSlip_m = 20e-6;
  constexpr double kLevel_N = 8.0;
  const auto position_m = [](double t_s) { return 0.01 * std::sin(5.0 * t_s) + 2e-3 * std::sin(17.0 * t_s); };
  double last_m = position_m(0.0);
  double z_m = 0.0;
  const Log log = test::log_of(1000.0, 20'000, position_m, [&](double t_s) {
    z_m = std::clamp(z_m + position_m(t_s) - last_m, -kSlip_m, kSlip_m);
    last_m = position_m(t_s);
    return kLevel_N * z_m / kSlip_m;
  });
  const Measurement measurement(log);
  Term hysteresis = make_term(measurement, *find_effect("presliding_hysteresis"));
  std::fill(hysteresis.shapes.begin(), hysteresis.shapes.end(), 0.0);
  hysteresis.shapes.front() = kSlip_m;
  const FittedModel base = fit_gains(measurement, {hysteresis});
  ASSERT_LT(base.holdout_rmse_N, 1e-3 * kLevel_N);
  const auto least_beyond_N = [&](const char* id) {
    const Visibility visibility = visibility_of(measurement, base, baseline_residual_maker(measurement, base),
                                                make_term(measurement, *find_effect(id)), 0.03);
    return visibility.least_rms_N * std::sqrt(visibility.share);
  };
  EXPECT_NEAR(least_beyond_N("viscous"), 0.005 * kLevel_N, 1e-3 * 0.005 * kLevel_N);
  EXPECT_LT(least_beyond_N("force_ripple"), 0.3 * 0.005 * kLevel_N);  // it repeats along the rail
}

}  // namespace
}  // namespace slipstack::workbench
