// SPDX-License-Identifier: Apache-2.0
// The bounded share of the comparison: four contenders on one axis, without what the axis may differ in. The
// whole is run by hand (docs/measured.md).
#include "workbench/loop/comparison/comparison.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace slipstack::workbench {
namespace {

TEST(Comparison, MaxwellSlipEarnsItsPlaceOnThePickAndPlaceAxis) {
  ComparisonFile nothing_kept;
  const Comparison comparison =
      compare({.first_seed = 11, .field = Field::kFew, .extent = {.robustness = false}}, nothing_kept,
              [](const std::string&, double) {});
  ASSERT_EQ(comparison.contenders.size(), 4U);
  const auto value = [&](std::size_t i, Measure measure) { return comparison.contenders[i].median(measure); };
  const double plain = value(0, Measure::kReversalRms);
  const double mass = value(1, Measure::kReversalRms);
  const double table = value(2, Measure::kReversalRms);
  const double ours = value(3, Measure::kReversalRms);
  EXPECT_LE(mass, plain);
  EXPECT_LT(table, mass);
  EXPECT_LT(ours, 0.5 * table);
  EXPECT_LT(ours, 0.15 * mass);
  // Less than this would need an explanation: a count of the encoder is 1 um.
  EXPECT_GT(ours, 0.05e-6);
  EXPECT_LT(value(3, Measure::kCircleMiddle), 0.5 * value(1, Measure::kCircleMiddle));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_GT(value(i, Measure::kEffort), 1.0) << i;
    EXPECT_LT(value(i, Measure::kJitter), 1e-6) << i;
  }
  const nlohmann::json json = comparison_json(comparison);
  EXPECT_EQ(json.at("contenders").size(), 4U);
  EXPECT_TRUE(json.at("contenders")[0].at("by_seed").at("warm_m")[0].is_null());
  const std::string text = comparison_text(comparison);
  EXPECT_NE(text.find("velocity table"), std::string::npos);
  EXPECT_EQ(text.find("Reversals when the axis differs"), std::string::npos);
}

}  // namespace
}  // namespace slipstack::workbench
