// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/feedback.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slipstack::workbench {
namespace {

TEST(CommissionFeedback, HasTheMarginThatIsAskedForAndAnyPartOfItMore) {
  for (const double mass_kg : {1.0, 35.0, 60.0}) {
    const Feedback full = full_feedback(mass_kg, 1e-4);
    EXPECT_GT(full.margins.modulus, 0.499) << mass_kg;
    EXPECT_LT(full.margins.modulus, 0.75) << mass_kg;
    EXPECT_GT(full.gains.velocity_gain_N_s_per_m, 50.0 * mass_kg);
    for (const double share : {0.2, 0.35, 0.6}) {
      const Feedback part = part_of(full, share);
      EXPECT_GT(part.margins.modulus, 0.5) << share;
      EXPECT_NEAR(part.gains.velocity_gain_N_s_per_m, share * full.gains.velocity_gain_N_s_per_m, 1e-9);
      EXPECT_LT(part.margins.crossover_Hz, full.margins.crossover_Hz);
    }
  }
}

TEST(CommissionFeedback, IsSteadyByTheScatterOfTheForceAtRest) {
  AxisRecord record;
  record.rate_Hz = 1000.0;
  for (int i = 0; i < 1000; ++i) {
    const bool at_rest = i >= 300 && i < 700;
    record.force_N.push_back(20.0 + (at_rest ? 1.0 : 30.0) * std::sin(0.5 * i));
  }
  EXPECT_TRUE(is_steady(record, 0.3, 0.7, 0.75));
  EXPECT_FALSE(is_steady(record, 0.3, 0.7, 0.65));
  EXPECT_FALSE(is_steady(record, 0.2, 0.7, 0.75));
  EXPECT_FALSE(is_steady(record, 0.9, 1.1, 100.0)) << "the record ends before";
  record.fault = "fault";
  EXPECT_FALSE(is_steady(record, 0.3, 0.7, 0.75));
}

}  // namespace
}  // namespace slipstack::workbench
