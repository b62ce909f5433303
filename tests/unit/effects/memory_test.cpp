// SPDX-License-Identifier: Apache-2.0
// Effects with a state, against solutions of their equations that do not step as they do.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

using test::Draw;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// A mode under an acceleration that is held over each tick: q'' + 2 zeta w q' + w^2 q = a, by classical
/// Runge-Kutta in steps of at most a hundredth of a radian.
class FineMode {
 public:
  FineMode(double frequency_Hz, double damping, double tick_s)
      : w_(kTwoPi * frequency_Hz), damping_(damping), tick_s_(tick_s) {
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
  const double w = kTwoPi * kFrequency_Hz;
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

constexpr double kNoDistance_m = 1e2;  // the upper bound: lag by time alone

template <class Real>
std::vector<double> lag_step_response(double lag_s, int ticks) {
  FrictionalLag<Real> effect;
  effect.prepare(std::array{Real(0.01), Real(1), static_cast<Real>(lag_s), static_cast<Real>(kNoDistance_m)},
                 {.tick_s = static_cast<Real>(test::kTick_s)});
  effect.reset({.velocity_mps = Real(1)});  // fast: nothing of the level at rest
  std::vector<double> response;
  for (int i = 0; i < ticks; ++i) {
    std::array<Real, 1> out{};
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
  const double rate_per_s = 1.0 / kLag_s + kSpeed_mps / kDistance_m;
  std::array<double, 1> out{};
  for (int i = 1; i <= 2000; ++i) {
    effect.basis({.velocity_mps = -kSpeed_mps}, out);
    EXPECT_NEAR(out[0], steady + (1.0 - steady) * std::exp(-rate_per_s * i * test::kTick_s), 5e-7) << i;
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
      std::array<double, 1> out{};
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
  std::array<float, 1> out{};
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
  std::array<double, 1> out{};
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
  std::array<double, 1> out{};
  for (int i = 0; i < 20'000; ++i) {
    const double phase = kTwoPi * 2.0 * i * test::kTick_s;
    const double velocity = 0.02 * (1.0 - std::cos(phase)) / 2.0;
    effect.basis({.velocity_mps = velocity}, out);
    if (i > 10'000) (std::sin(phase) > 0.0 ? up : down) += out[0];
  }
  EXPECT_GT(up, 1.2 * down);
}

/// Stop operators summed up from steps: another way than the anchors of the firmware.
template <std::size_t N>
class SummedStops {
 public:
  explicit SummedStops(const std::array<double, N>& slip_m) : slip_m_(slip_m) {}
  void move(double step_m) {
    for (std::size_t i = 0; i < N; ++i) {
      stretch_m_[i] = std::min(slip_m_[i], std::max(-slip_m_[i], stretch_m_[i] + step_m));
    }
  }
  double operator[](std::size_t i) const { return stretch_m_[i]; }

 private:
  std::array<double, N> slip_m_;
  std::array<double, N> stretch_m_{};
};

TEST(PreslidingHysteresis, IsASetOfStopOperators) {
  using Effect = PreslidingHysteresis<double>;
  Draw draw(21);
  const auto slip_m = test::random_shapes<Effect>(draw);
  Effect effect;
  effect.prepare(slip_m, {.tick_s = test::kTick_s, .metres_per_displacement = 1.0});
  effect.reset({.displacement = 0.2});
  SummedStops<kIdentifiedElements> exact(slip_m);
  double x_m = 0.2;
  std::array<double, kIdentifiedElements> out{};
  for (int i = 0; i < 50'000; ++i) {
    const double before = x_m;
    x_m += draw.sign() * draw.log_uniform(1e-9, 1e-3);
    effect.basis({.displacement = x_m}, out);
    exact.move(x_m - before);
    for (std::size_t k = 0; k < out.size(); ++k) ASSERT_NEAR(out[k], exact[k], 1e-12) << i;
  }
}

TEST(PreslidingHysteresis, CountsAreExactOnTheTarget) {
  using Effect = PreslidingHysteresis<float>;
  Draw draw(22);
  const auto slip_m = test::random_shapes<Effect>(draw);
  Effect effect;
  effect.prepare(test::as<float>(slip_m),
                 {.tick_s = 1e-4F, .metres_per_displacement = static_cast<float>(test::kResolution_m)});
  std::int32_t x = 2'000'000'000;  // wraps around on the way
  effect.reset({.displacement = x});
  SummedStops<kTargetElements> exact(slip_m);
  std::array<float, kTargetElements> out{};
  for (int i = 0; i < 50'000; ++i) {
    const auto step =
        static_cast<std::int32_t>(draw.sign() * draw.log_uniform(1.0, 1e6)) + (i < 400 ? 500'000 : 0);
    x = static_cast<std::int32_t>(static_cast<std::uint32_t>(x) + static_cast<std::uint32_t>(step));
    effect.basis({.displacement = x}, out);
    exact.move(step * test::kResolution_m);
    for (std::size_t k = 0; k < out.size(); ++k) {
      ASSERT_NEAR(static_cast<double>(out[k]), exact[k], 2e-7 * slip_m[k]) << i;
    }
  }
}

TEST(PreslidingHysteresis, UnusedElementsAreZero) {
  std::array<float, kTargetElements> slip_m{};
  slip_m[3] = 1e-6F;
  PreslidingHysteresis<float> effect;
  effect.prepare(slip_m, {.tick_s = 1e-4F, .metres_per_displacement = 1e-7F});
  effect.reset({});
  std::array<float, kTargetElements> out{};
  effect.basis({.displacement = 1000}, out);
  for (std::size_t k = 0; k < out.size(); ++k) EXPECT_FLOAT_EQ(out[k], k == 3 ? 1e-6F : 0.0F);
}

// The finest encoders count in tens of picometres; the upper bound of a slip distance is then beyond any
// count, and the others must be taken all the same.
TEST(PreslidingHysteresis, TakesEverySlipDistanceOfItsBounds) {
  for (const float resolution_m : {1e-5F, 1e-9F, 4e-10F, 2e-11F}) {
    std::array<float, kTargetElements> slip_m{};
    slip_m[0] = 1e-6F;
    slip_m[1] = PreslidingHysteresis<float>::shapes[1].upper;
    PreslidingHysteresis<float> effect;
    effect.prepare(slip_m, {.tick_s = 1e-4F, .metres_per_displacement = resolution_m});
    effect.reset({});
    std::array<float, kTargetElements> out{};
    const std::int32_t travel = 1 << 20;
    effect.basis({.displacement = travel}, out);
    const float travel_m = static_cast<float>(travel) * resolution_m;
    const float rounded_m = std::round(1e-6F / resolution_m) * resolution_m;
    EXPECT_NEAR(out[0], std::min(rounded_m, travel_m), 1e-5F * rounded_m) << resolution_m;
    EXPECT_NEAR(out[1], std::min(travel_m, 1.0F), 1e-5F * travel_m) << resolution_m;
  }
}

}  // namespace
}  // namespace slipstack
