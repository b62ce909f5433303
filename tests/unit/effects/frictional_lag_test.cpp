// SPDX-License-Identifier: Apache-2.0
// The lagging weakening against its exponential and its equation.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

using test::Draw;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

constexpr double kNoDistance_m = 1e2;  // the upper bound: lag by time alone

template <class Real>
std::vector<double> lag_step_response(double lag_s, int ticks) {
  FrictionalLag<Real> effect;
  effect.prepare(std::array{Real(0.01), Real(1), static_cast<Real>(lag_s), static_cast<Real>(kNoDistance_m)},
                 {.tick_s = static_cast<Real>(test::kTick_s)});
  effect.reset({.velocity_mps = Real(1)});  // fast: nothing of the level at rest
  std::vector<double> response;
  for (int i = 0; i < ticks; ++i) {
    std::array<Real, 2> out{};
    effect.basis({.velocity_mps = Real(0)}, out);
    response.push_back(static_cast<double>(out[0]));
  }
  return response;
}

TEST(FrictionalLag, StepResponseIsAnExponential) {
  const int ticks = 4000;
  for (const double lag_s : {4e-4, 3e-3, 0.05, 2.0}) {
    const auto is = lag_step_response<double>(lag_s, ticks);
    const auto is_float = lag_step_response<float>(lag_s, ticks);
    double worst = 0.0;
    double worst_float = 0.0;
    for (int i = 0; i < ticks; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double should = 1.0 - std::exp(-(i + 1) * test::kTick_s / lag_s);
      worst = std::max(worst, std::abs(is[at] - should));
      worst_float = std::max(worst_float, std::abs(is_float[at] - is[at]));
    }
    // Second order in the tick: the time constant is off by a twelfth of (tick / lag) squared.
    const double ratio = test::kTick_s / lag_s;
    EXPECT_LT(worst, 3e-8 + ratio * ratio / 12.0 / std::numbers::e * 1.3) << lag_s;
    EXPECT_GT(worst, 0.3 * ratio * ratio / 12.0 / std::numbers::e) << lag_s;
    // Increments below half a last place are lost: the level stops that far from its end.
    EXPECT_LT(worst_float, 2e-7 + 0.5 * 1.2e-7 / ratio) << lag_s;
  }
}

// At constant speed the memory of the start fades with the way as much as with time.
TEST(FrictionalLag, FadesWithTimeAndWithDistance) {
  constexpr double kSpeed_mps = 0.02;
  constexpr double kLag_s = 0.1;
  constexpr double kDistance_m = 1e-3;
  FrictionalLag<double> effect;
  effect.prepare(std::array{0.01, 1.0, kLag_s, kDistance_m}, {.tick_s = test::kTick_s});
  effect.reset({.velocity_mps = 0.0});
  const double steady = std::exp(-kSpeed_mps / 0.01);
  const double steady_with_tail = 1.0 / (1.0 + kSpeed_mps / 0.01);
  const double rate_per_s = 1.0 / kLag_s + kSpeed_mps / kDistance_m;
  std::array<double, 2> out{};
  for (int i = 1; i <= 2000; ++i) {
    effect.basis({.velocity_mps = -kSpeed_mps}, out);
    const double left = std::exp(-rate_per_s * i * test::kTick_s);
    EXPECT_NEAR(out[0], steady + (1.0 - steady) * left, 5e-7) << i;
    EXPECT_NEAR(out[1], steady_with_tail + (1.0 - steady_with_tail) * left, 5e-7) << i;
  }
}

// A random speed against fine steps of the equation, and never past the level that it tends to.
TEST(FrictionalLag, FollowsItsEquation) {
  for (const double lag_s : {5e-4, 0.02, 1.0}) {
    FrictionalLag<double> effect;
    effect.prepare(std::array{0.01, 1.0, lag_s, 2e-3}, {.tick_s = test::kTick_s});
    effect.reset({.velocity_mps = 0.0});
    Draw draw(4);
    double exact = 1.0;
    double worst = 0.0;
    double velocity = 0.0;
    for (int i = 0; i < 5000; ++i) {
      if (i % 37 == 0) velocity = draw.sign() * draw.log_uniform(1e-4, 0.3);
      const double steady = std::exp(-std::abs(velocity) / 0.01);
      const double rate_per_s = 1.0 / lag_s + std::abs(velocity) / 2e-3;
      exact = steady + (exact - steady) * std::exp(-rate_per_s * test::kTick_s);
      std::array<double, 2> out{};
      effect.basis({.velocity_mps = velocity}, out);
      worst = std::max(worst, std::abs(out[0] - exact));
    }
    EXPECT_LT(worst, 2e-3) << lag_s;
    EXPECT_GT(worst, 1e-8) << lag_s;
  }
}

TEST(FrictionalLag, NeverOvershoots) {
  FrictionalLag<float> effect;
  effect.prepare(std::array{0.01F, 1.0F, 1e-4F, 1e-6F}, {.tick_s = 1e-3F});
  effect.reset({.velocity_mps = 0.0F});
  std::array<float, 2> out{};
  effect.basis({.velocity_mps = 2.0F}, out);
  EXPECT_GE(out[0], 0.0F);
  EXPECT_LT(out[0], 1e-20F);
  effect.basis({.velocity_mps = 0.0F}, out);
  EXPECT_LE(out[0], 1.0F);
  EXPECT_GT(out[0], 0.9F);
}

TEST(FrictionalLag, StartsWhereTheVelocityIs) {
  FrictionalLag<double> effect;
  effect.prepare(std::array{0.01, 1.0, 0.1, kNoDistance_m}, {.tick_s = test::kTick_s});
  effect.reset({.velocity_mps = -0.02});
  std::array<double, 2> out{};
  for (int i = 0; i < 100; ++i) effect.basis({.velocity_mps = -0.02}, out);
  EXPECT_NEAR(out[0], std::exp(-2.0), 1e-8);
}

// Speeding up, the level is higher than slowing down: that is what the effect is for.
TEST(FrictionalLag, OpensALoopAgainstVelocity) {
  FrictionalLag<double> effect;
  effect.prepare(std::array{0.01, 1.0, 0.05, kNoDistance_m}, {.tick_s = test::kTick_s});
  effect.reset({});
  double up = 0.0;
  double down = 0.0;
  std::array<double, 2> out{};
  for (int i = 0; i < 20'000; ++i) {
    const double phase = kTwoPi * 2.0 * i * test::kTick_s;
    const double velocity = 0.02 * (1.0 - std::cos(phase)) / 2.0;
    effect.basis({.velocity_mps = velocity}, out);
    if (i > 10'000) (std::sin(phase) > 0.0 ? up : down) += out[0];
  }
  EXPECT_GT(up, 1.2 * down);
}

}  // namespace
}  // namespace slipstack
