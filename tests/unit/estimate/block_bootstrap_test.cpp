// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/block_bootstrap.h"

#include <gtest/gtest.h>

#include "tests/unit/estimate/estimate_support.h"

namespace slipstack::workbench {
namespace {

/// Squared errors of blocks whose rms scatters from block to block.
std::vector<double> drawn_blocks(test::Draw& draw, std::size_t count, double rows) {
  std::vector<double> squared;
  squared.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double rms = 2.0 * (1.0 + 0.2 * draw.normal());
    squared.push_back(rows * rms * rms);
  }
  return squared;
}

TEST(BlockBootstrap, CoversTheTruth) {
  test::Draw draw(1);
  const std::vector<double> weights(60, 50.0);
  const double truth = 2.0 * std::sqrt(1.0 + 0.2 * 0.2);
  int covered = 0;
  constexpr int kRecords = 400;
  for (int record = 0; record < kRecords; ++record) {
    const ConfidenceInterval interval = block_bootstrap(drawn_blocks(draw, 60, 50.0), weights);
    covered += interval.low <= truth && truth <= interval.high ? 1 : 0;
  }
  // 95 % promised; the bootstrap of sixty blocks falls a little short.
  EXPECT_GE(covered, 0.88 * kRecords);
  EXPECT_LE(covered, 0.99 * kRecords);
}

TEST(BlockBootstrap, SameBlocksSameIntervalAndScalesWithThem) {
  test::Draw draw(2);
  const std::vector<double> weights(30, 7.0);
  std::vector<double> squared = drawn_blocks(draw, 30, 7.0);
  const ConfidenceInterval once = block_bootstrap(squared, weights);
  const ConfidenceInterval twice = block_bootstrap(squared, weights);
  EXPECT_EQ(once.low, twice.low);
  EXPECT_EQ(once.high, twice.high);
  EXPECT_LT(once.low, once.high);
  for (double& value : squared) value *= 1e6;  // the same in mN
  const ConfidenceInterval scaled = block_bootstrap(squared, weights);
  EXPECT_NEAR(scaled.low, 1e3 * once.low, 1e-9 * scaled.low);
  EXPECT_NEAR(scaled.high, 1e3 * once.high, 1e-9 * scaled.high);
}

TEST(BlockBootstrap, EqualBlocksLeaveNoDoubt) {
  const ConfidenceInterval interval =
      block_bootstrap(std::vector<double>(10, 90.0), std::vector<double>(10, 10.0));
  EXPECT_NEAR(interval.low, 3.0, 1e-12);
  EXPECT_NEAR(interval.high, 3.0, 1e-12);
}

}  // namespace
}  // namespace slipstack::workbench
