// SPDX-License-Identifier: Apache-2.0
// Errors on data that the parameters have not seen.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/estimate/uncertainty/row_weights.h"

namespace slipstack::workbench {
namespace {

constexpr double kNoiseOfSweep_N = 0.05;
constexpr double kForceBeyond_N = 6.0;
constexpr double kSecondsOfSweep = 60.0;
constexpr double kSweep_per_s = 3.0;

/// A sweep to and fro, of `later` times the stroke from within the last third on, with a constant force
/// beyond the stroke of the first two; fitted with inertia and dry friction and judged.
FittedModel judged(double later) {
  test::Draw draw(1);
  const auto position_m = [later](double t) {
    const double kept_s = 42.0 * std::numbers::pi / kSweep_per_s;  // 21 sweeps, 44 s
    return 0.05 * (t < kept_s ? 1.0 : later) * (1.0 - std::cos(kSweep_per_s * t));
  };
  const auto force_N = [&](double t) {
    const double beyond_N = position_m(t) > 0.12 ? kForceBeyond_N : 0.0;
    return 5.0 * std::tanh(1e3 * (position_m(t + 5e-4) - position_m(t - 5e-4))) + beyond_N +
           kNoiseOfSweep_N * draw.normal();
  };
  Measurement measurement(
      test::log_of(1000.0, static_cast<std::size_t>(1000.0 * kSecondsOfSweep), position_m, force_N));
  weigh_rows(measurement);
  FittedModel model = fit_effects(measurement, {"inertia", "coulomb"}, {});
  judge_on_unseen_data(measurement, model);
  return model;
}

// A place where the axis was not before cannot be predicted, and says nothing of what the model claims.
TEST(HeldOutError, ForwardWithinTheTravelLeavesOutNewPlaces) {
  const FittedModel farther = judged(2.0);
  EXPECT_GT(farther.forward_rmse_N, 0.4 * kForceBeyond_N);
  EXPECT_LT(farther.forward_within_travel_N, 0.1 * kForceBeyond_N);
  EXPECT_GT(farther.forward_within_travel_N, 0.0);
}

TEST(HeldOutError, ForwardWithinTheTravelIsAllWhereTheAxisGoesNoFarther) {
  for (const double later : {1.0, 0.5}) {
    const FittedModel same = judged(later);
    EXPECT_GT(same.forward_rmse_N, 0.0);
    EXPECT_NEAR(same.forward_within_travel_N, same.forward_rmse_N, 0.02 * same.forward_rmse_N) << later;
  }
}

// All of what is held out has the force beyond the stroke, which is in the last third: a third of the rows
// has the whole of the squares.
TEST(HeldOutError, TheLastThirdHasItsPartOfTheHeldOutError) {
  const FittedModel farther = judged(2.0);
  EXPECT_NEAR(farther.last_third_holdout_rmse_N, std::sqrt(3.0) * farther.holdout_rmse_N,
              0.05 * farther.last_third_holdout_rmse_N);
  const FittedModel same = judged(1.0);
  EXPECT_NEAR(same.last_third_holdout_rmse_N, same.holdout_rmse_N, 0.05 * same.holdout_rmse_N);
}

}  // namespace
}  // namespace slipstack::workbench
