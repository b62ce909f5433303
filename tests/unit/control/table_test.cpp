// SPDX-License-Identifier: Apache-2.0
// What the controller reads from tables, against the functions they were filled from; and parameters that
// change in motion. Errors are held from both sides: a table that became exact is no longer a table.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>

#include "firmware/effects/numerics/power_table.h"
#include "firmware/effects/numerics/ripple_table.h"
#include "firmware/effects/numerics/speed_table.h"
#include "firmware/friction/packed_maxwell_slip.h"

namespace slipstack {
namespace {

// The two weakenings that the table holds, by their place in it.
double law(std::size_t column, double u) {
  return column == 0 ? std::exp(-u) : 1.0 / (1.0 + u);
}

struct WorstError {
  double small_n = 0.0;
  double large_n = 0.0;
};

WorstError worst_error(std::size_t column) {
  auto table = std::make_unique<SpeedTable>();
  WorstError worst;
  for (double n = 0.4; n <= 3.0; n += 0.05) {
    for (const double vs_mps : {1e-5, 3.3e-3, 1.0}) {
      const auto at = [&](std::size_t own, double v) { return law(own, std::pow(v / vs_mps, n)); };
      table->fill(static_cast<float>(vs_mps), static_cast<float>(n), [&](float v) -> SpeedTable::Values {
        return {static_cast<float>(at(0, static_cast<double>(v))),
                static_cast<float>(at(1, static_cast<double>(v)))};
      });
      double& own = n < 0.799 ? worst.small_n : worst.large_n;
      for (double octave = -40.0; octave < 12.0; octave += 0.003) {
        const auto v = static_cast<float>(vs_mps * std::exp2(octave));
        const double is = static_cast<double>(table->at(v)[column]);
        own = std::max(own, std::abs(is - at(column, static_cast<double>(v))));
        if (table->at(v) != table->at(-v)) ADD_FAILURE() << "not even at " << v;
      }
    }
  }
  return worst;
}

TEST(SpeedTable, ErrorIsWhatItsHeaderSays) {
  const WorstError without = worst_error(0);
  EXPECT_LT(without.small_n, 4.8e-4);
  EXPECT_GT(without.small_n, 3.5e-4);
  EXPECT_LT(without.large_n, 3.1e-4);
  EXPECT_GT(without.large_n, 2.2e-4);
  const WorstError with = worst_error(1);
  EXPECT_LT(with.small_n, 4.8e-4);
  EXPECT_LT(with.large_n, 3.1e-4);
  EXPECT_GT(std::min(with.small_n, with.large_n), 1.5e-4);
}

TEST(SpeedTable, EndsAreOneAndZeroAndWildInputIsHarmless) {
  auto table = std::make_unique<SpeedTable>();
  table->fill(0.01F, 1.0F, [](float v) -> SpeedTable::Values {
    return {std::exp(-v / 0.01F), 1.0F / (1.0F + v / 0.01F)};
  });
  EXPECT_NEAR(table->at(0.0F)[0], 1.0F, 1e-4F);
  EXPECT_NEAR(table->at(1e-30F)[0], 1.0F, 1e-4F);
  for (const float wild : {1e30F, -std::numeric_limits<float>::infinity(), std::nanf("")}) {
    EXPECT_GE(table->at(wild)[0], -1e-5F);
    EXPECT_LT(table->at(wild)[0], 1e-5F);
    EXPECT_NEAR(table->at(wild)[1], 0.0F, 3e-4F);
  }
}

TEST(PowerTable, RelativeErrorIsWhatItsHeaderSays) {
  double worst = 0.0;
  for (double p = 0.5; p <= 1.5; p += 0.01) {
    PowerTable table;
    table.fill(static_cast<float>(p));
    for (double octave = -24.0; octave < 8.0; octave += 0.0013) {
      const auto x = static_cast<float>(std::exp2(octave));
      const double wanted = std::pow(static_cast<double>(x), static_cast<double>(static_cast<float>(p)));
      worst = std::max(worst, std::abs(static_cast<double>(table.at(x)) / wanted - 1.0));
    }
  }
  EXPECT_LT(worst, 6.5e-6);
  EXPECT_GT(worst, 5.0e-6);
}

TEST(PowerTable, ThePowerOneIsTheNumberItself) {
  PowerTable table;
  table.fill(1.0F);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> octave(-24.0F, 8.0F);
  for (int i = 0; i < 100000; ++i) {
    const float x = std::exp2(octave(random));
    EXPECT_NEAR(table.at(x) / x, 1.0F, 3e-7F) << x;
  }
}

TEST(PowerTable, IsHarmlessOutsideItsRange) {
  PowerTable table;
  table.fill(0.5F);
  EXPECT_NEAR(table.at(0.0F), 0x1p-12F, 1e-9F);
  EXPECT_NEAR(table.at(1e-30F), 0x1p-12F, 1e-9F);
  for (const float wild : {256.0F, 1e30F, std::numeric_limits<float>::infinity(), std::nanf("")}) {
    EXPECT_NEAR(table.at(wild), 16.0F, 1e-3F);
  }
}

TEST(RippleTable, ErrorOfEachHarmonicIsWhatItsHeaderSays) {
  constexpr std::array<double, 4> kLargest = {8e-6, 6.2e-5, 2.1e-4, 5e-4};
  RippleTable table;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-40.0F, 40.0F);
  for (std::size_t h = 1; h <= kLargest.size(); ++h) {
    const auto wave = [h](double cycles) {
      return std::sin(2.0 * std::numbers::pi * static_cast<double>(h) * cycles + 0.3);
    };
    table.fill([&](float cycles) { return static_cast<float>(wave(static_cast<double>(cycles))); });
    double worst = 0.0;
    for (int i = 0; i < 100000; ++i) {
      const float cycles = place(random);
      worst = std::max(worst,
                       std::abs(static_cast<double>(table.at(cycles)) - wave(static_cast<double>(cycles))));
    }
    EXPECT_LT(worst, kLargest[h - 1]) << h;
    EXPECT_GT(worst, kLargest[h - 1] * 0.5) << h;
  }
}

// An exact model of one stop operator in counts.
std::int32_t stop(std::int32_t z, std::int32_t step, std::int32_t limit) {
  return std::clamp(z + step, -limit, limit);
}

TEST(CarryOver, ContinuesTheMotionWithOtherParameters) {
  constexpr std::size_t kElements = 10;
  std::mt19937 random(11);
  const auto draw_slips = [&random] {
    std::array<std::int32_t, kElements> slip{};
    for (std::int32_t& distance : slip) distance = 1 << std::uniform_int_distribution<int>(0, 13)(random);
    return slip;
  };
  std::array<float, kElements> stiffness{};
  stiffness.fill(0.3F);
  PackedMaxwellSlip<kElements> model;
  auto slip = draw_slips();
  ASSERT_EQ(model.set_elements(slip, stiffness), SetupStatus::kOk);
  model.reset(-5);
  std::array<std::int32_t, kElements> z{};
  std::int32_t x = -5;
  for (int i = 0; i < 200000; ++i) {
    if (i % 37 == 0) {
      slip = draw_slips();
      PackedMaxwellSlip<kElements> next;
      ASSERT_EQ(next.set_elements(slip, stiffness), SetupStatus::kOk);
      next.carry_over(model);
      model = next;
      for (std::size_t e = 0; e < kElements; ++e) z[e] = stop(z[e], 0, slip[e]);
    } else {
      const std::int32_t step = std::uniform_int_distribution<int>(-300, 300)(random) >> (i % 9);
      x += step;
      model.step(x);
      for (std::size_t e = 0; e < kElements; ++e) z[e] = stop(z[e], step, slip[e]);
    }
    for (std::size_t e = 0; e < kElements; ++e) ASSERT_EQ(model.z(e), z[e]) << i << ' ' << e;
  }
}

}  // namespace
}  // namespace slipstack
