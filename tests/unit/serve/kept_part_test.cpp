// SPDX-License-Identifier: Apache-2.0
// Which part of a recording with gaps becomes a log.
#include "workbench/serve/live/kept_part.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace slipstack::workbench {
namespace {

constexpr StreamedAxis kStreamed{.rate_Hz = 500.0, .tick_s = 1e-3};

/// Samples of a motion to and fro over so many counts, after a gap of so many samples.
struct Stretch {
  int gap = 0;
  int samples = 0;
  int travel_counts = 0;
};

std::vector<StreamSample> recorded(const std::vector<Stretch>& stretches) {
  std::vector<StreamSample> samples;
  std::int64_t tick = 100'000;
  for (const Stretch& stretch : stretches) {
    tick += 2 * static_cast<std::int64_t>(stretch.gap);
    for (int i = 0; i < stretch.samples; ++i) {
      const double way = std::sin(std::numbers::pi * i / stretch.samples);
      StreamSample sample;
      sample.tick = tick += 2;
      sample.counts = static_cast<std::int32_t>(std::lround(way * stretch.travel_counts));
      samples.push_back(sample);
    }
  }
  return samples;
}

std::size_t kept(const std::vector<Stretch>& stretches) {
  return part_to_keep(recorded(stretches), kStreamed).size();
}

TEST(KeptPart, IsAllWithoutALongGap) {
  EXPECT_EQ(kept({}), 0U);
  EXPECT_EQ(kept({{0, 1200, 100}}), 1200U);
  EXPECT_EQ(kept({{0, 700, 100}, {9, 800, 100}}), 1500U);
  EXPECT_EQ(kept({{0, 700, 100}, {10, 800, 100}}), 800U);
}

TEST(KeptPart, IsTheLongestThatMovesEnough) {
  EXPECT_EQ(kept({{0, 5000, 1}, {50, 1100, 400}}), 1100U) << "an encoder at rest dithers";
  EXPECT_EQ(kept({{0, 5000, 199}, {50, 1100, 400}}), 1100U);
  EXPECT_EQ(kept({{0, 5000, 200}, {50, 1100, 400}}), 5000U);
  EXPECT_EQ(kept({{0, 5000, 0}, {50, 1100, 0}}), 5000U);
}

// However far the axis goes in it, less than two seconds are no log.
TEST(KeptPart, IsLongEnoughWhereOneIs) {
  EXPECT_EQ(kept({{0, 999, 1000}, {50, 1000, 20}}), 1000U);
  EXPECT_EQ(kept({{0, 900, 1000}, {50, 999, 20}}), 999U);
  const auto part = part_to_keep(recorded({{0, 999, 1000}, {50, 1000, 20}}), kStreamed);
  EXPECT_EQ(part.front().tick, 100'000 + 2 * (999 + 50 + 1));
}

}  // namespace
}  // namespace slipstack::workbench
