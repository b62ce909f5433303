// SPDX-License-Identifier: Apache-2.0
// Margins against closed forms and brute force.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "workbench/frequency/margins.h"

namespace slipstack::workbench {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// k / (s (s + a) (s + b)): the angle is -180 degrees at w^2 = a b, where |L| = k / (a b (a + b)).
struct ThirdOrder {
  double k, a, b;
  Complex at(double frequency_Hz) const {
    const Complex s(0.0, kTurn * frequency_Hz);
    return k / (s * (s + a) * (s + b));
  }
};

TEST(Margins, OfAThirdOrderLoopAreTheClosedForm) {
  std::mt19937_64 random(1);
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<>()(random));
  };
  for (int i = 0; i < 50; ++i) {
    const double a = between(10.0, 100.0);
    const double b = between(100.0, 1000.0);
    const double gain = between(1.3, 10.0);
    const ThirdOrder system{a * b * (a + b) / gain, a, b};
    std::vector<double> frequency_Hz;
    std::vector<Complex> loop;
    for (double f = 0.05; f < 2000.0; f *= 1.01) {
      frequency_Hz.push_back(f);
      loop.push_back(system.at(f));
    }
    const Margins found = margins_of(frequency_Hz, loop);
    EXPECT_NEAR(found.gain / gain, 1.0, 0.002);
    EXPECT_NEAR(found.gain_Hz * kTurn / std::sqrt(a * b), 1.0, 0.002);
    EXPECT_EQ(found.gain_down, 0.0);
    // By bisection on the exact response.
    double low = 0.01;
    double high = 2000.0;
    for (int step = 0; step < 100; ++step) {
      const double middle = std::sqrt(low * high);
      (std::abs(system.at(middle)) > 1.0 ? low : high) = middle;
    }
    EXPECT_NEAR(found.crossover_Hz / low, 1.0, 0.002);
    EXPECT_NEAR(found.phase_rad, std::numbers::pi + std::arg(system.at(low)), 0.002);
    double modulus = 1e9;
    for (double f = 0.05; f < 2000.0; f *= 1.0005) modulus = std::min(modulus, std::abs(1.0 + system.at(f)));
    EXPECT_GE(found.modulus, modulus * 0.9999);
    EXPECT_LE(found.modulus, modulus * 1.01);
  }
}

// A loop with `gain` margin g is stable below g and has two right poles beyond.
TEST(Margins, TurnsTellStableFromUnstable) {
  std::vector<Complex> running;
  const ThirdOrder system{1.0, 20.0, 300.0};
  const double limit = 20.0 * 300.0 * 320.0;
  const auto scaled = [&](double share) {
    std::vector<Complex> loop;
    for (double f = 0.05; f < 2000.0; f *= 1.01) loop.push_back(share * limit * system.at(f));
    return loop;
  };
  running = scaled(0.3);
  for (const double share : {0.1, 0.5, 0.9, 0.99}) EXPECT_EQ(extra_turns(scaled(share), running), 0) << share;
  for (const double share : {1.01, 1.5, 5.0}) EXPECT_NE(extra_turns(scaled(share), running), 0) << share;
}

}  // namespace
}  // namespace slipstack::workbench
