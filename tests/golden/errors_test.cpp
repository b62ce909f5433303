// SPDX-License-Identifier: Apache-2.0
// The errors that a fit states are those of the model that it returns.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/golden/shared_data.h"
#include "workbench/base/axis_units.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

const std::vector<std::string> kLogs{
    "hidden_effect/blind_1.csv", "hidden_effect/blind_2.csv",       "hidden_effect/blind_3.csv",
    "hidden_effect/blind_4.csv", "hidden_effect/blind_5.csv",       "hidden_effect/blind_6.csv",
    "emps/emps_estimation.csv",  "tribometer/tribometer_loops.csv", "odrive_cogging/odrive_0p1rev.csv"};

/// Friction, inertia where the log declares no mass of zero, and further effects.
Terms model_of(const Measurement& measurement, const std::vector<const EffectDescription*>& further) {
  Terms terms;
  for (const std::string& id : default_baseline())
    terms.push_back(term_for_log(measurement, *find_effect(id)));
  for (const EffectDescription* effect : further) {
    if (!contains(terms, effect->text.id)) terms.push_back(term_for_log(measurement, *effect));
  }
  return terms;
}

/// Logs of rotary and of linear axes, each with its own units.
class StatedErrors : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { forget_axis(); }
  void TearDown() override { forget_axis(); }
};

/// All pairs of effects, in both orders of the model where one of them multiplies others.
std::vector<std::pair<const EffectDescription*, const EffectDescription*>> all_pairs() {
  const auto& effects = catalogue();
  std::vector<std::pair<const EffectDescription*, const EffectDescription*>> pairs;
  for (std::size_t i = 0; i < effects.size(); ++i) {
    for (std::size_t j = 0; j < effects.size(); ++j) {
      const bool multiplies = effects[i].acts_as(Acts::dry_scale) || effects[i].acts_as(Acts::total_scale);
      if (i < j || (i > j && multiplies)) pairs.emplace_back(&effects[i], &effects[j]);
    }
  }
  return pairs;
}

// With the shapes in the middle of their ranges: what multiplies, and with what, is the same for all shapes.
// The force of the returned model is evaluated here anew, without the fit's columns.
TEST_P(StatedErrors, AreThoseOfTheModel) {
  const auto path = shared_file(GetParam().c_str());
  SKIP_WITHOUT(path);
  const Measurement measurement = measured(path);
  const auto pairs = all_pairs();
  std::size_t unfinished = 0;
  for (const auto& [one, other] : pairs) {
    FittedModel fitted = fit_gains(measurement, model_of(measurement, {one, other}));
    judge_on_unseen_data(measurement, fitted);
    const Eigen::VectorXd left_N = measurement.force_N(measurement_dynamics_of(fitted.terms)) -
                                   measurement.filtered(evaluate_force(measurement, fitted.terms).force_N);
    const std::string names = one->id() + " and " + other->id();
    EXPECT_NEAR(measurement.weighted_rms(left_N), fitted.train_rmse_N, 0.001 * fitted.train_rmse_N) << names;
    // Where shapes were not searched: a fold may find better ones than the middle of their ranges.
    if (one->shapes.empty() && other->shapes.empty()) {
      EXPECT_GE(fitted.holdout_rmse_N, 0.97 * fitted.train_rmse_N) << names;
    }
    // A fit that starts there finds no lower error, or it was said that it may.
    const FittedModel again = fit_gains(measurement, fitted.terms, &fitted);
    if (fitted.converged) {
      EXPECT_GT(again.train_rmse_N, 0.995 * fitted.train_rmse_N) << names;
    } else {
      ++unfinished;
    }
  }
  EXPECT_LE(40 * unfinished, pairs.size());
}

std::string name_of_log(const testing::TestParamInfo<std::string>& info) {
  const std::string path = info.param;
  const std::size_t first = path.find('/') + 1;
  return path.substr(first, path.find('.') - first);
}
INSTANTIATE_TEST_SUITE_P(Logs, StatedErrors, testing::ValuesIn(kLogs), name_of_log);

}  // namespace
}  // namespace slipstack::workbench
