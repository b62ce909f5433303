// SPDX-License-Identifier: Apache-2.0
// Effects without memory: their bases against the formulas, written out here with the C library.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

using test::Draw;
using Values = std::vector<double>;

double sign(double x) {
  return x < 0.0 ? -1.0 : 1.0;
}

Values ripple(const Sample<double>& s, const Values& p) {
  Values out;
  for (int h = 1; h <= 4; ++h) {
    const double angle = 2.0 * std::numbers::pi * h * s.position_m / p[0];
    out.push_back(std::cos(angle));
    out.push_back(std::sin(angle));
  }
  return out;
}

/// What each basis must be.
template <class E>
struct Formula;
template <class R>
struct Formula<Inertia<R>> {
  static Values of(const Sample<double>& s, const Values&) { return {s.acceleration_mps2}; }
};
template <class R>
struct Formula<PayloadMass<R>> : Formula<Inertia<R>> {};
template <class R>
struct Formula<Coulomb<R>> {
  static Values of(const Sample<double>& s, const Values& p) {
    return {std::max(-1.0, std::min(1.0, s.velocity_mps / p[0]))};
  }
};
template <class R>
struct Formula<Viscous<R>> {
  static Values of(const Sample<double>& s, const Values&) { return {s.velocity_mps}; }
};
template <class R>
struct Formula<QuadraticDrag<R>> {
  static Values of(const Sample<double>& s, const Values& p) {
    return {sign(s.velocity_mps) * std::pow(std::abs(s.velocity_mps), p[0])};
  }
};
template <class R>
struct Formula<Stribeck<R>> {
  static Values of(const Sample<double>& s, const Values& p) {
    const double u = std::pow(std::abs(s.velocity_mps) / p[0], p[1]);
    return {std::exp(-u), 1.0 / (1.0 + u)};
  }
};
template <class R>
struct Formula<AccelerationDependentPreload<R>> {
  static Values of(const Sample<double>& s, const Values& p) {
    const double a = std::abs(s.acceleration_mps2);
    return {a * p[0] / (p[0] + a), a * a / (p[0] + a)};
  }
};
template <class R>
struct Formula<DirectionAsymmetry<R>> {
  static Values of(const Sample<double>& s, const Values& p) {
    const double u = std::max(-1.0, std::min(1.0, s.velocity_mps / p[0]));
    return {sign(s.dry_friction_N), 1.5 * u - 0.5 * std::pow(u, 3.0), std::abs(s.velocity_mps)};
  }
};
template <class R>
struct Formula<ForceRipple<R>> {
  static Values of(const Sample<double>& s, const Values& p) { return ripple(s, p); }
};
template <class R>
struct Formula<MotorConstantRipple<R>> {
  static Values of(const Sample<double>& s, const Values& p) { return ripple(s, p); }
};
template <class R>
struct Formula<OffsetForce<R>> {
  static Values of(const Sample<double>&, const Values&) { return {1.0}; }
};
template <class R>
struct Formula<CableChainStiffness<R>> {
  static Values of(const Sample<double>& s, const Values& p) {
    const double u = std::max(-1.0, std::min(1.0, 2.0 * (s.position_m - p[0]) / p[1] - 1.0));
    return {s.position_m, 1.0, (3.0 * u * u - 1.0) / 2.0, (5.0 * std::pow(u, 3.0) - 3.0 * u) / 2.0};
  }
};
template <class R>
struct Formula<Drift<R>> {
  static Values of(const Sample<double>& s, const Values& p) {
    return {(1.0 - std::exp(-std::min(s.time_s, p[1]) / p[0])) / (1.0 - std::exp(-p[1] / p[0]))};
  }
};

/// How far a basis may lie from its formula, for each unit of the larger of 1 and the formula's value:
/// `series` is what the polynomials of approx.h leave, `rounding` what float does in units of 2^-23.
struct Allowed {
  double series;
  double rounding;
};
template <class E>
constexpr Allowed kAllowed{0.0, 1.0};
template <class R>
constexpr Allowed kAllowed<AccelerationDependentPreload<R>>{0.0, 2.0};
template <class R>
constexpr Allowed kAllowed<Stribeck<R>>{1.5e-8, 4.0};
template <class R>
constexpr Allowed kAllowed<QuadraticDrag<R>>{1.0e-8, 4.0};
// A quotient of two exponentials, each of which deviates by 8e-9 of itself.
template <class R>
constexpr Allowed kAllowed<Drift<R>>{1.6e-8, 2.0};
// The middle of the stroke is rounded, and so is the place in half a stroke of 0.05 m; the cubic is six
// times as steep at its ends.
template <class R>
constexpr Allowed kAllowed<CableChainStiffness<R>>{0.0, 8.0};
// The fourth harmonic turns four times as fast: its error is four times that of the first.
template <class R>
constexpr Allowed kAllowed<ForceRipple<R>>{1.8e-7, 6.0};
template <class R>
constexpr Allowed kAllowed<MotorConstantRipple<R>>{1.8e-7, 6.0};

/// Rounding of x / pitch turns the fourth harmonic by this, in units of 2^-23.
double phase_rounding(const ShapeSpec& spec, double position_m, double shape) {
  if (spec.kind != ShapeKind::pitch) return 0.0;
  return 2.0 * std::numbers::pi * 4.0 * std::abs(position_m / shape);
}

constexpr double kFloatRounding = 1.1920928955078125e-7;

template <template <class> class E>
void expect_formula() {
  Draw draw(11);
  double worst_double = 0.0;
  double worst_float = 0.0;
  const Scales<double> scales{.tick_s = test::kTick_s, .metres_per_displacement = 1.0};
  const Scales<float> float_scales{.tick_s = 1e-4F, .metres_per_displacement = 1e-7F};
  constexpr Allowed allowed = kAllowed<E<double>>;
  for (int trial = 0; trial < 400; ++trial) {
    const auto shapes = test::random_shapes<E<double>>(draw);
    const auto float_shapes = test::as<float>(shapes);
    E<double> effect;
    E<float> target;
    effect.prepare(shapes, scales);
    target.prepare(float_shapes, float_scales);
    for (int k = 0; k < 50; ++k) {
      const Sample<double> sample = test::random_sample(draw);
      const Values should = Formula<E<double>>::of(sample, {shapes.begin(), shapes.end()});
      std::array<double, E<double>::gain_count> is{};
      std::array<float, E<float>::gain_count> is_float{};
      effect.basis(sample, is);
      target.basis(test::on_target(sample), is_float);
      ASSERT_EQ(should.size(), is.size());
      double phase = 0.0;
      if constexpr (E<double>::shape_count > 0) {
        phase = phase_rounding(E<double>::shapes[0], sample.position_m, shapes[0]);
      }
      for (std::size_t g = 0; g < is.size(); ++g) {
        const double unit = std::max(1.0, std::abs(should[g]));
        worst_double = std::max(worst_double, std::abs(is[g] - should[g]) / unit);
        worst_float = std::max(worst_float, std::abs(static_cast<double>(is_float[g]) - is[g]) / unit /
                                                (allowed.rounding + phase));
      }
    }
  }
  EXPECT_LE(worst_double, allowed.series + 1e-12);
  EXPECT_GE(worst_double, 0.2 * allowed.series);
  EXPECT_LE(worst_float, kFloatRounding);
}

TEST(Basis, Inertia) {
  expect_formula<Inertia>();
}
TEST(Basis, PayloadMass) {
  expect_formula<PayloadMass>();
}
TEST(Basis, Coulomb) {
  expect_formula<Coulomb>();
}
TEST(Basis, Viscous) {
  expect_formula<Viscous>();
}
TEST(Basis, QuadraticDrag) {
  expect_formula<QuadraticDrag>();
}
TEST(Basis, Stribeck) {
  expect_formula<Stribeck>();
}
TEST(Basis, AccelerationDependentPreload) {
  expect_formula<AccelerationDependentPreload>();
}
TEST(Basis, DirectionAsymmetry) {
  expect_formula<DirectionAsymmetry>();
}
TEST(Basis, ForceRipple) {
  expect_formula<ForceRipple>();
}
TEST(Basis, MotorConstantRipple) {
  expect_formula<MotorConstantRipple>();
}
TEST(Basis, OffsetForce) {
  expect_formula<OffsetForce>();
}
TEST(Basis, CableChainStiffness) {
  expect_formula<CableChainStiffness>();
}
TEST(Basis, Drift) {
  expect_formula<Drift>();
}

/// Over the stroke from -0.1 to 0.3 m: a line, then what bends.
std::array<double, 4> chain_at(double position_m) {
  CableChainStiffness<double> chain;
  chain.prepare(std::array{-0.1, 0.4}, {.tick_s = 1e-4});
  std::array<double, 4> out{};
  chain.basis({.position_m = position_m}, out);
  return out;
}

/// Means over the stroke of f, by Simpson's rule: exact to rounding for the polynomials here.
template <class F>
double mean_over_stroke(F&& f) {
  constexpr int kHalves = 2000;
  double sum = 0.0;
  for (int i = 0; i <= kHalves; ++i) {
    const double weight = i == 0 || i == kHalves ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    sum += weight * f(-0.1 + 0.4 * i / kHalves);
  }
  return sum / (3.0 * kHalves);
}

// So that the stiffness is the mean slope, whether or not the chain stiffens.
TEST(Basis, CableChainBendsBesideItsLineAndMean) {
  for (const std::size_t bend : {2U, 3U}) {
    for (const std::size_t line : {0U, 1U}) {
      EXPECT_NEAR(mean_over_stroke([&](double x) { return chain_at(x)[bend] * chain_at(x)[line]; }), 0.0,
                  1e-11)
          << bend << ' ' << line;
    }
  }
  EXPECT_NEAR(mean_over_stroke([](double x) { return chain_at(x)[2] * chain_at(x)[3]; }), 0.0, 1e-11);
  EXPECT_NEAR(mean_over_stroke([](double x) { return std::pow(chain_at(x)[2], 2.0); }), 1.0 / 5.0, 1e-9);
}

// u (1 + s u^2) about a rest position x0, u = x - x0: any cubic of the place is met exactly.
TEST(Basis, CableChainMeetsACubicChain) {
  Draw draw(7);
  for (int trial = 0; trial < 100; ++trial) {
    const double stiffness = draw.uniform(1.0, 100.0);
    const double bend = draw.uniform(0.1, 20.0);
    const double rest_m = draw.uniform(-0.2, 0.3);
    const auto chain_N = [&](double x) {
      return stiffness * (x - rest_m) * (1.0 + bend * std::pow(x - rest_m, 2.0));
    };
    std::array<double, 4> gains{};
    const auto part = [&](std::size_t g, double per) {
      return mean_over_stroke([&](double x) { return chain_N(x) * chain_at(x)[g]; }) * per;
    };
    gains[2] = part(2, 5.0);
    gains[3] = part(3, 7.0);
    gains[0] = mean_over_stroke([&](double x) { return chain_N(x) * (x - 0.1); }) * 3.0 / (0.2 * 0.2);
    gains[1] = part(1, 1.0) - 0.1 * gains[0];
    for (double x = -0.1; x <= 0.3; x += 0.013) {
      const auto basis = chain_at(x);
      double sum = 0.0;
      for (std::size_t g = 0; g < 4; ++g) sum += gains[g] * basis[g];
      EXPECT_NEAR(sum, chain_N(x), 1e-7 * stiffness) << rest_m;
    }
  }
}

// Where the log showed nothing a cubic would run away: the line goes on, what bends keeps its last value.
TEST(Basis, CableChainBendsNoFartherBeyondTheStroke) {
  for (const double beyond_m : {0.0, 1e-6, 0.01, 1.0, 1e3}) {
    EXPECT_NEAR(chain_at(-0.1 - beyond_m)[2], 1.0, 1e-12);
    EXPECT_NEAR(chain_at(-0.1 - beyond_m)[3], -1.0, 1e-12);
    EXPECT_NEAR(chain_at(0.3 + beyond_m)[2], 1.0, 1e-12);
    EXPECT_NEAR(chain_at(0.3 + beyond_m)[3], 1.0, 1e-12);
    EXPECT_EQ(chain_at(0.3 + beyond_m)[0], 0.3 + beyond_m);
    EXPECT_EQ(chain_at(0.3 + beyond_m)[1], 1.0);
  }
}

TEST(Basis, StribeckIsWholeAtRestAndGoneWhenFast) {
  for (const double exponent : {0.4, 1.0, 3.0}) {
    Stribeck<double> effect;
    effect.prepare(std::array{0.01, exponent}, {.tick_s = 1e-4});
    std::array<double, 2> out{};
    effect.basis({.velocity_mps = 0.0}, out);
    EXPECT_NEAR(out[0], 1.0, 2e-12);
    EXPECT_NEAR(out[1], 1.0, 2e-12);
    effect.basis({.velocity_mps = 1e4}, out);
    EXPECT_GE(out[0], 0.0);
    EXPECT_LT(out[0], 1e-30 + std::exp(-std::pow(1e6, exponent)));
    EXPECT_GT(out[1], 0.0);
    EXPECT_LE(out[1], 1.000001 * std::pow(1e6, -exponent));
  }
}

TEST(Basis, DriftStartsAtZero) {
  Drift<float> effect;
  effect.prepare(std::array{1e6F, 1e9F}, {.tick_s = 1e-4F});
  std::array<float, 1> out{1.0F};
  effect.basis({.time_s = 0.0F}, out);
  EXPECT_EQ(out[0], 0.0F);
  effect.basis({.time_s = 1e-4F}, out);
  EXPECT_NEAR(out[0] * 1e10F, 1.0F, 1e-6F);
}

// With a time constant that is long against what was observed it is proportional to time; nothing is
// compensated that was not seen.
TEST(Basis, DriftEndsWhereNobodyHasSeenIt) {
  Drift<float> effect;
  effect.prepare(std::array{1e6F, 60.0F}, {.tick_s = 1e-4F});
  std::array<float, 1> out{};
  for (const float time_s : {6.0F, 30.0F, 60.0F, 61.0F, 1e5F}) {
    effect.basis({.time_s = time_s}, out);
    EXPECT_NEAR(out[0], std::min(time_s / 60.0F, 1.0F), 1e-4F);
  }
}

TEST(Basis, TimeDelayAddsNoForce) {
  static_assert(TimeDelay<float>::gain_count == 0);
  static_assert(TimeDelay<float>::shape_count == 2);
}

}  // namespace
}  // namespace slipstack
