// SPDX-License-Identifier: Apache-2.0
// When one more effect is a step of the search.
#include "workbench/diagnose/evidence/naming_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/uncertainty/row_weights.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

TEST(OneStandardError, IsMoreThanAFallInOneBlockAgainstARiseInTheOthers) {
  const std::vector<double> after(20, 1.0);
  std::vector<double> everywhere(20, 2.0);
  EXPECT_TRUE(is_beyond_its_error(reduction(everywhere, after)));
  std::vector<double> in_one(20, 0.9);
  in_one[7] = 20.0;
  EXPECT_FALSE(is_beyond_its_error(reduction(in_one, after)));
  EXPECT_FALSE(is_beyond_its_error(reduction(after, after)));
  EXPECT_FALSE(is_beyond_its_error(reduction(after, everywhere)));  // it rises
}

/// The baseline and the explanation with one more effect of a log with viscous friction.
class Improvement : public ::testing::Test {
 protected:
  Measurement measurement_ = weighed(Measurement(viscous_log()));
  FittedModel baseline_ = fit_gains(measurement_, {make_term(measurement_, *find_effect("inertia"))});
  Explanation before_{baseline_, {}};
  Explanation after_ = with(make_term(measurement_, *find_effect("viscous")));

  static Measurement weighed(Measurement measurement) {
    weigh_rows(measurement);
    return measurement;
  }
  static Log viscous_log() {
    test::Draw draw(3);
    const auto position_m = [](double t) { return 0.05 * std::sin(2.0 * t) + 0.01 * std::sin(7.3 * t); };
    return test::log_of(1000.0, 20'000, position_m, [&draw](double t) {
      return 8.0 * (0.1 * std::cos(2.0 * t) + 0.073 * std::cos(7.3 * t)) + 0.3 * draw.normal();
    });
  }
  Explanation with(Term term) {
    Terms terms = baseline_.terms;
    const std::string id = term.id();
    terms.push_back(std::move(term));
    return {fit_gains(measurement_, terms), {id}};
  }
  bool is_improvement_of(const Explanation& before, const Explanation& after) {
    return is_improvement({measurement_, baseline_, Criterion(measurement_, baseline_.terms, 20)}, before,
                          after);
  }
};

TEST_F(Improvement, IsNotOneOfOneBlockWhereTheOthersGetWorse) {
  EXPECT_TRUE(is_improvement_of(before_, after_));
  Explanation of_one_block = before_;
  std::vector<double>& squares = of_one_block.model.block_squared_error;
  const double sum = std::accumulate(squares.begin(), squares.end(), 0.0);
  squares = after_.model.block_squared_error;
  for (double& square : squares) square *= 0.9;
  squares.front() += sum - std::accumulate(squares.begin(), squares.end(), 0.0);
  EXPECT_FALSE(is_improvement_of(of_one_block, after_));
}

}  // namespace
}  // namespace slipstack::workbench
