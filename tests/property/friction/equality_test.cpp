// SPDX-License-Identifier: Apache-2.0
// The two descriptions of hysteresis agree, and both agree with slow models that share nothing with them.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/memory_stack.h"
#include "tests/property/friction/motion.h"
#include "tests/property/friction/oracles.h"

namespace slipstack::test {
namespace {

constexpr std::size_t kElements = 12;
constexpr std::size_t kDepth = 256;
constexpr std::int32_t kRange = 100;  // nested loops on integers: never more than 200 reversals

// Twelve elements with ascending slip distances and the piecewise-linear curve that is equal to them.
template <class Displacement>
struct Pair {
  std::array<Displacement, kElements> slip_distance{};
  std::array<double, kElements> stiffness{};
  MaxwellSlip<kElements, double, Displacement> elements;
  MemoryStack<PiecewiseLinearCurve<kElements, double>, kDepth, Displacement> stack{{}};

  // Slip distances are whole multiples of `unit`, stiffnesses integers: sums of their products are exact.
  Pair(std::uint64_t seed, Displacement unit) {
    NestedMotion random(seed, 1);
    std::int32_t distance = 0;
    for (std::size_t i = 0; i < kElements; ++i) {
      distance += random.between(1, 15);
      slip_distance[i] = static_cast<Displacement>(distance) * unit;
      stiffness[i] = random.between(0, 40);
    }
    std::array<double, kElements> knots{};
    std::array<double, kElements> slopes{};
    double slope = 0;
    for (std::size_t i = kElements; i-- > 0;) {
      slope += stiffness[i];
      slopes[i] = slope;
      knots[i] = static_cast<double>(slip_distance[i]);
    }
    PiecewiseLinearCurve<kElements, double> curve;
    EXPECT_EQ(curve.set_slopes(knots, slopes), SetupStatus::kOk);
    EXPECT_EQ(elements.set_elements(slip_distance, stiffness), SetupStatus::kOk);
    stack.set_curve(curve);
  }
};

TEST(MaxwellSlipAndMemoryStack, AgreeToTheBitOnCounts) {
  constexpr int kSteps = 250000;
  std::size_t deepest = 0;
  std::size_t most_closed = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Pair<std::int32_t> pair(seed, 1);
    NestedMotion motion(1000 + seed, kRange);
    for (int i = 0; i < kSteps; ++i) {
      const std::int32_t x = motion.next();
      const std::size_t before = pair.stack.depth();
      ASSERT_EQ(pair.elements.step(x), pair.stack.step(x)) << "seed " << seed << " step " << i;
      const std::size_t depth = pair.stack.depth();
      deepest = std::max(deepest, depth);
      if (depth < before) most_closed = std::max(most_closed, (before - depth + 1) / 2);
    }
    EXPECT_EQ(pair.stack.overflow_count(), 0U);
  }
  // The motion must be worth the name: deep nesting, and many loops closed by one step.
  EXPECT_GT(deepest, 90U);
  EXPECT_GT(most_closed, 40U);
}

TEST(MaxwellSlipAndMemoryStack, AgreeToRoundingInMetres) {
  constexpr int kSteps = 100000;
  constexpr double kUnit = 1e-7;
  double worst = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Pair<double> pair(seed, kUnit);
    NestedMotion motion(2000 + seed, kRange);
    double saturation = 0;
    for (std::size_t i = 0; i < kElements; ++i) saturation += pair.stiffness[i] * pair.slip_distance[i];
    for (int i = 0; i < kSteps; ++i) {
      const double x = motion.next() * kUnit * 1.37;
      worst = std::max(worst, std::abs(pair.elements.step(x) - pair.stack.step(x)) / saturation);
    }
  }
  EXPECT_LT(worst, 1e-12);
  EXPECT_GT(worst, 0.0);
}

// All loops by construction: nest as deep as the range allows, then close 1, 2, ... all of them in one step.
TEST(MaxwellSlipAndMemoryStack, AgreeWhenOneStepClosesAnyNumberOfLoops) {
  for (std::int32_t closed = 0; closed <= 50; ++closed) {
    for (std::int32_t side = -1; side <= 1; side += 2) {
      Pair<std::int32_t> pair(77, 1);
      for (std::int32_t amplitude = kRange; amplitude > 0; --amplitude) {
        const std::int32_t x = amplitude % 2 == 0 ? side * amplitude : -side * amplitude;
        ASSERT_EQ(pair.elements.step(x), pair.stack.step(x));
      }
      ASSERT_EQ(pair.stack.depth(), static_cast<std::size_t>(kRange - 1));
      // On the side of the last point the reversals stand at 3, 5, ... 99; the first, at 100, is closed by
      // its image.
      const std::int32_t x = -side * (2 * closed + 2);
      ASSERT_EQ(pair.elements.step(x), pair.stack.step(x)) << closed << " loops";
      const std::size_t expected = closed >= 49 ? 0 : static_cast<std::size_t>(kRange - 1 - 2 * closed);
      EXPECT_EQ(pair.stack.depth(), expected) << closed;
      for (std::int32_t back = -kRange; back <= kRange; back += 7) {
        ASSERT_EQ(pair.elements.step(back), pair.stack.step(back));
      }
    }
  }
}

TEST(MemoryStack, AgreesWithTheWholeHistorySearchedAnew) {
  constexpr int kSteps = 1200;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    MemoryStack<RationalCurve<double>, kDepth, std::int32_t> rational({15.0, 12.0});
    MemoryStack<ExponentialCurve<double>, kDepth, std::int32_t> exponential({4.75, 20.0});
    FullHistoryModel slow_rational([](double x) { return 15.0 * (1 - std::pow(12.0 / (x + 12.0), 2)); });
    FullHistoryModel slow_exponential([](double x) { return 4.75 * -std::expm1(-x / 20.0); });
    NestedMotion motion(3000 + seed, seed % 4 == 0 ? 5 : kRange);
    for (int i = 0; i < kSteps; ++i) {
      const std::int32_t x = motion.next();
      ASSERT_NEAR(rational.step(x), slow_rational.step(x), 1e-11) << "seed " << seed << " step " << i;
      ASSERT_NEAR(exponential.step(x), slow_exponential.step(x), 1e-11) << "seed " << seed << " step " << i;
      ASSERT_EQ(rational.depth(), slow_rational.reversals()) << "seed " << seed << " step " << i;
    }
  }
}

TEST(MaxwellSlip, AgreesWithRelays) {
  constexpr int kSteps = 4000;
  constexpr std::int32_t kRelayRange = 40;
  constexpr std::array<std::int32_t, 6> kSlip = {0, 1, 3, 8, 20, 60};
  constexpr std::array<double, 6> kStiffness = {1, 2, 3, 4, 5, 6};
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    MaxwellSlip<6, double, std::int32_t> elements;
    ASSERT_EQ(elements.set_elements(kSlip, kStiffness), SetupStatus::kOk);
    std::vector<RelayElement> relays;
    for (const std::int32_t slip : kSlip) relays.emplace_back(slip, kRelayRange + 60);
    NestedMotion motion(4000 + seed, kRelayRange);
    for (int i = 0; i < kSteps; ++i) {
      const std::int32_t x = motion.next();
      double force = 0;
      const double fast_force = elements.step(x);
      for (std::size_t j = 0; j < kSlip.size(); ++j) {
        const std::int32_t z = relays[j].step(x);
        ASSERT_EQ(elements.z(j), z) << "seed " << seed << " step " << i << " element " << j;
        force += kStiffness[j] * z;
      }
      ASSERT_EQ(fast_force, force);
    }
  }
}

}  // namespace
}  // namespace slipstack::test
