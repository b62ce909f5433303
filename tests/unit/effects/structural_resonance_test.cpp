// SPDX-License-Identifier: Apache-2.0
// The mode against Runge-Kutta in fine steps, and against its closed form.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

using test::Draw;
constexpr double kRadPerTurn = 2.0 * std::numbers::pi;

/// A mode under an acceleration that is held over each tick: q'' + 2 zeta w q' + w^2 q = a, by classical
/// Runge-Kutta in steps of at most a hundredth of a radian.
class FineMode {
 public:
  FineMode(double frequency_Hz, double damping, double tick_s)
      : w_(kRadPerTurn * frequency_Hz), damping_(damping), tick_s_(tick_s) {
    steps_ = 1 + static_cast<int>(w_ * tick_s / 0.01);
  }
  void hold(double a) {
    const double h = tick_s_ / steps_;
    for (int i = 0; i < steps_; ++i) {
      const State k1 = rate(state_, a);
      const State k2 = rate(moved(k1, 0.5 * h), a);
      const State k3 = rate(moved(k2, 0.5 * h), a);
      const State k4 = rate(moved(k3, h), a);
      for (std::size_t j = 0; j < 2; ++j) state_[j] += h / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j]);
    }
  }
  double spring() const { return w_ * w_ * state_[0]; }
  double damper() const { return w_ * state_[1]; }

 private:
  using State = std::array<double, 2>;
  State rate(const State& s, double a) const {
    return {s[1], a - 2.0 * damping_ * w_ * s[1] - w_ * w_ * s[0]};
  }
  State moved(const State& k, double h) const { return {state_[0] + h * k[0], state_[1] + h * k[1]}; }

  double w_;
  double damping_;
  double tick_s_;
  int steps_;
  State state_{};
};

template <class Real>
StructuralResonance<Real> mode(double frequency_Hz, double damping, double tick_s) {
  StructuralResonance<Real> effect;
  effect.prepare(std::array{static_cast<Real>(frequency_Hz), static_cast<Real>(damping)},
                 {.tick_s = static_cast<Real>(tick_s)});
  effect.reset({});
  return effect;
}

struct ModeError {
  double in_double;
  double in_float;
};

/// Largest error over 4000 ticks of random held accelerations, relative to the largest response.
ModeError mode_error(double frequency_Hz, double damping, double tick_s, std::uint64_t seed) {
  Draw draw(seed);
  auto effect = mode<double>(frequency_Hz, damping, tick_s);
  auto target = mode<float>(frequency_Hz, damping, tick_s);
  FineMode exact(frequency_Hz, damping, tick_s);
  double peak = 0.0;
  ModeError worst{};
  double a = 0.0;
  for (int i = 0; i < 4000; ++i) {
    if (draw.uniform(0.0, 1.0) < 0.02) a = static_cast<double>(static_cast<float>(draw.uniform(-10.0, 10.0)));
    exact.hold(a);
    std::array<double, 3> is{};
    std::array<float, 3> is_float{};
    effect.basis({.acceleration_mps2 = a}, is);
    target.basis({.acceleration_mps2 = static_cast<float>(a)}, is_float);
    EXPECT_EQ(is[2], a);
    peak = std::max({peak, std::abs(exact.spring()), std::abs(exact.damper())});
    worst.in_double =
        std::max({worst.in_double, std::abs(is[0] - exact.spring()), std::abs(is[1] - exact.damper())});
    worst.in_float = std::max({worst.in_float, std::abs(static_cast<double>(is_float[0]) - is[0]),
                               std::abs(static_cast<double>(is_float[1]) - is[1])});
  }
  return {worst.in_double / peak, worst.in_float / peak};
}

TEST(Resonance, FollowsTheEquationOfMotion) {
  struct Case {
    double frequency_Hz, damping, tick_s;
  };
  double worst = 0.0;
  double worst_float = 0.0;
  for (const Case& c : {Case{5.0, 0.02, 1e-4}, Case{37.0, 0.01, 1e-4}, Case{120.0, 0.05, 2e-4},
                        Case{300.0, 0.005, 1e-4}, Case{1900.0, 0.1, 1e-4}, Case{0.5, 0.5, 1e-3}}) {
    const ModeError error = mode_error(c.frequency_Hz, c.damping, c.tick_s, 3);
    worst = std::max(worst, error.in_double);
    worst_float = std::max(worst_float, error.in_float);
  }
  EXPECT_LT(worst, 2e-6);
  EXPECT_GT(worst, 1e-9);
  EXPECT_LT(worst_float, 2e-4);
  EXPECT_GT(worst_float, 1e-7);
}

// After a single pulse the mode rings alone: w^2 q = Re(C lambda^n) in closed form.
TEST(Resonance, RingsAndDecaysInClosedForm) {
  constexpr double kFrequency_Hz = 31.0;
  constexpr double kDamping = 0.015;
  const double w = kRadPerTurn * kFrequency_Hz;
  const double damped = w * std::sqrt(1.0 - kDamping * kDamping);
  const std::complex<double> root(-kDamping * w, damped);
  auto effect = mode<double>(kFrequency_Hz, kDamping, test::kTick_s);
  std::array<double, 3> out{};
  effect.basis({.acceleration_mps2 = 1.0}, out);
  // From rest under a held unit: u = 1 + 2 Re(C exp(root t)) with u(0) = u'(0) = 0.
  const std::complex<double> c = std::conj(root) / (root - std::conj(root));
  const auto held = [&](double t) { return 1.0 + 2.0 * std::real(c * std::exp(root * t)); };
  double worst = 0.0;
  for (int n = 1; n < 30'000; ++n) {
    const double t = n * test::kTick_s;
    const double should = held(t) - held(t - test::kTick_s);
    worst = std::max(worst, std::abs(out[0] - should));
    effect.basis({.acceleration_mps2 = 0.0}, out);
  }
  const double first = held(test::kTick_s);
  EXPECT_LT(worst / first, 1e-9);
  EXPECT_GT(worst / first, 1e-13);
}

TEST(Resonance, SettlesAtTheAccelerationWithoutGain) {
  auto effect = mode<double>(20.0, 0.1, test::kTick_s);
  std::array<double, 3> out{};
  for (int i = 0; i < 30'000; ++i) effect.basis({.acceleration_mps2 = 3.0}, out);
  EXPECT_NEAR(out[0], 3.0, 1e-9);
  EXPECT_NEAR(out[1], 0.0, 1e-9);
}

// The corner of the bounds where float has least room: damping of one tick near its last bit.
TEST(Resonance, FloatNeverRingsUp) {
  for (const float tick_s : {5e-5F, 1e-4F, 2.5e-4F, 1e-3F}) {
    for (const float frequency_Hz : {0.5F, 0.7F, 1.0F, 3.0F, 30.0F, 300.0F, 2000.0F}) {
      StructuralResonance<float> effect;
      effect.prepare(std::array{frequency_Hz, 1e-3F}, {.tick_s = tick_s});
      effect.reset({});
      std::array<float, 3> out{};
      effect.basis({.acceleration_mps2 = 1.0F}, out);
      float early = 0.0F;
      float late = 0.0F;
      const int turn = 1 + static_cast<int>(1.0F / (frequency_Hz * tick_s));
      const int ticks = std::max(20 * turn, 20'000);
      for (int i = 0; i < ticks; ++i) {
        effect.basis({.acceleration_mps2 = 0.0F}, out);
        float& window = i < 2 * turn ? early : late;
        if (i < 2 * turn || i >= ticks - 2 * turn) window = std::max(window, std::abs(out[0]));
      }
      EXPECT_LT(late, early) << frequency_Hz << " Hz, tick " << tick_s;
    }
  }
}

}  // namespace
}  // namespace slipstack
