// SPDX-License-Identifier: Apache-2.0
// The share by which an error falls, its standard error, and when that is significant.
#include "workbench/diagnose/evidence/reduction.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slipstack::workbench {
namespace {

// Of two blocks the jackknife has a closed form: half the difference of what either shows alone.
TEST(Reduction, OfTwoBlocksHasTheScatterBetweenThem) {
  const Reduction found = reduction({4.0, 4.0}, {1.0, 3.24});
  EXPECT_NEAR(found.value, 1.0 - std::sqrt(4.24 / 8.0), 1e-12);
  EXPECT_NEAR(found.standard_error, 0.5 * std::abs(std::sqrt(3.24 / 4.0) - std::sqrt(1.0 / 4.0)), 1e-12);
}

TEST(Reduction, IsSignificantAboveItsErrorAndWorthAName) {
  EXPECT_TRUE(is_significant({0.05, 0.04}));
  EXPECT_FALSE(is_significant({0.05, 0.06}));
  EXPECT_FALSE(is_significant({0.02, 0.001}));
  EXPECT_FALSE(is_significant({-0.2, 0.1}));
}

// What helps in half of the blocks and harms in the others is chance, though it helps more.
TEST(Reduction, IsJudgedByAllBlocks) {
  const std::vector<double> before(6, 1.0);
  EXPECT_TRUE(is_significant(reduction(before, {0.8, 0.9, 0.85, 0.8, 0.9, 0.85})));
  const Reduction uneven = reduction(before, {0.2, 1.2, 0.4, 1.4, 0.3, 1.8});
  EXPECT_GT(uneven.value, kLeastReduction);
  EXPECT_FALSE(is_significant(uneven));
}

}  // namespace
}  // namespace slipstack::workbench
