// SPDX-License-Identifier: Apache-2.0
// When a step is significant, and when a lag is a frictional lag.
#include "workbench/diagnose/evidence/significance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/model/effects/effect_registry.h"

namespace slipstack::workbench {
namespace {

using Blocks = std::vector<double>;

/// Squared errors of thirty blocks, which an effect lowers by about `share`.
Blocks lowered(const Blocks& before, double share, double scatter, std::uint64_t seed) {
  test::Draw draw(seed);
  Blocks after;
  for (const double one : before) after.push_back(one * (1.0 - share - scatter * draw.uniform(-1.0, 1.0)));
  return after;
}

TEST(LoweredSignificantly, ByAnEffectThatIsStrongInTwoBlocksAndVisibleInTheOthers) {
  Blocks before(30, 1.0);
  Blocks after = lowered(before, 0.3, 0.3, 1);
  before[7] = 150.0;
  after[7] = 15.0;
  before[21] = 20.0;
  after[21] = 2.0;
  EXPECT_FALSE(reduction(before, after).is_significant());
  EXPECT_TRUE(lowered_significantly(before, after));
}

TEST(LoweredSignificantly, NotByAnEffectInTwoBlocksOnly) {
  Blocks before(30, 1.0);
  Blocks after = lowered(before, 0.0, 0.2, 2);
  before[7] = before[21] = 15.0;
  after[7] = after[21] = 5.0;
  EXPECT_GT(reduction(before, after).value, 0.1);
  EXPECT_FALSE(lowered_significantly(before, after));
}

TEST(LoweredSignificantly, NotByLessThanTheLeastReduction) {
  const Blocks before(30, 1.0);
  EXPECT_FALSE(lowered_significantly(before, Blocks(30, 0.96)));  // 2 % of the error
  EXPECT_TRUE(lowered_significantly(before, Blocks(30, 0.9)));
}

/// A model with these errors by block, one of the terms `more` beside an inertia.
FittedModel with_errors(const Measurement& measurement, const Blocks& squared_error, const char* more) {
  FittedModel model;
  model.terms = {make_term(measurement, *find_effect("inertia"))};
  if (more != nullptr) model.terms.push_back(make_term(measurement, *find_effect(more)));
  model.block_squared_error = squared_error;
  double sum = 0.0;
  for (const double one : squared_error) sum += one;
  model.holdout_rmse_N = std::sqrt(sum / static_cast<double>(squared_error.size()));
  return model;
}

// The best of a hundred pitches without effect often exceeds three standard errors.
TEST(IsSignificant, WidelySearchedShapesNeedMoreStandardErrors) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  const NoiseFloor floor(measurement);
  const Blocks before(20, 1.0);
  const FittedModel baseline = with_errors(measurement, before, nullptr);
  const SelectionContext context{baseline, floor, measurement.tick_s(), measurement.bandwidth_Hz(), 1.0};
  const Blocks noisy = lowered(before, 0.27, 0.52, 3);
  const Reduction is = reduction(before, noisy);
  ASSERT_LT(is.value, 0.15);
  ASSERT_GT(is.value, 3.1 * is.standard_error);
  ASSERT_LT(is.value, 4.3 * is.standard_error);
  EXPECT_TRUE(is_significant(context, baseline, with_errors(measurement, noisy, "viscous")));
  EXPECT_FALSE(is_significant(context, baseline, with_errors(measurement, noisy, "force_ripple")));
  const Blocks sure = lowered(before, 0.27, 0.2, 3);
  EXPECT_TRUE(is_significant(context, baseline, with_errors(measurement, sure, "force_ripple")));
}

// Where neither reaches the noise floor, Stribeck friction is preferred, unless the lag explains nearly all
// that it leaves.
TEST(ExplainsAsWell, StribeckFrictionOfAnotherFormAsALag) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  const NoiseFloor floor(measurement);
  const FittedModel before = with_errors(measurement, Blocks(20, 1e4), nullptr);
  const SelectionContext context{before, floor, measurement.tick_s(), measurement.bandwidth_Hz(), 1.0};
  const double floor_N2 = std::pow(floor.of(with_errors(measurement, {1.0}, "frictional_lag").terms), 2);
  const auto stands = [&](double stribeck, double lag) {
    return explains_as_well(context, with_errors(measurement, Blocks(20, stribeck * floor_N2), "stribeck"),
                            with_errors(measurement, Blocks(20, lag * floor_N2), "frictional_lag"), before);
  };
  EXPECT_TRUE(stands(2.1, 2.0));    // nearly as good
  EXPECT_FALSE(stands(4.0, 2.0));   // the lag is the axis
  EXPECT_TRUE(stands(26.0, 7.0));   // 76 % of what is left above the floor
  EXPECT_FALSE(stands(26.0, 5.5));  // 82 %
}

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

TEST(LagIsBristleDeflection, OverThePreSlidingTravelAndNotInTime) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  EXPECT_TRUE(lag_is_bristle_deflection(with_lag(measurement, 100.0, 30e-6)));
  EXPECT_FALSE(lag_is_bristle_deflection(with_lag(measurement, 100.0, 1e-3)));   // memory of a film
  EXPECT_FALSE(lag_is_bristle_deflection(with_lag(measurement, 0.015, 30e-6)));  // and in time
  FittedModel none = with_lag(measurement, 100.0, 30e-6);
  none.terms.pop_back();
  EXPECT_FALSE(lag_is_bristle_deflection(none));
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

TEST(HasNoTrueMode, WhereMostOfAFittedMassSwings) {
  const Measurement measurement(test::wandering_log(1, 2000.0, 6000));
  EXPECT_FALSE(has_no_true_mode(with_arm(measurement, 0.3)));
  EXPECT_FALSE(has_no_true_mode(with_arm(measurement, 2.8)));  // 58 % of both
  EXPECT_TRUE(has_no_true_mode(with_arm(measurement, 3.2)));   // 62 %
}

}  // namespace
}  // namespace slipstack::workbench
