// SPDX-License-Identifier: Apache-2.0
// Event-exact dynamics: energy audit, turning points from the energy balance, closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "sim_host/plant/exact_axis.h"
#include "sim_host/rng.h"

namespace slipstack::sim {
namespace {

MaxwellElements random_bank(Rng& rng, std::size_t elements) {
  CurveTerm term;
  term.kind = rng.pick({CurveKind::kExponential, CurveKind::kRational, CurveKind::kStretched});
  term.level_N = rng.log_uniform(1.0, 30.0);
  term.length_m = rng.log_uniform(1e-6, 3e-5);
  term.exponent = term.kind == CurveKind::kStretched ? 0.8 : 1.0;
  return MaxwellElements::sample(VirginCurve({term}), elements);
}

TEST(ExactAxis, WorkEqualsKineticPlusStoredPlusDissipated) {
  std::size_t events = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Rng rng(seed);
    LinearPart linear;
    linear.mass_kg = rng.log_uniform(1.0, 60.0);
    if (rng.chance(0.5)) linear.viscous_N_s_per_m = rng.uniform(0.0, 50.0);
    if (rng.chance(0.5)) linear.spring_N_per_m = rng.log_uniform(10.0, 1e5);
    if (rng.chance(0.4)) {
      linear.arm_ratio = rng.uniform(0.05, 0.4);
      linear.arm_rad_per_s = rng.uniform(50.0, 400.0);
      linear.arm_damping_ratio = rng.uniform(0.0, 0.1);
    }
    MaxwellElements bank = random_bank(rng, 1 + rng.below(200));
    const double level_N = bank.saturation_N();
    ExactAxis axis(linear, bank);
    double throughput_J = 0.0;
    double last_work_J = 0.0;
    for (int i = 1; i <= 200; ++i) {
      // Forces from well inside pre-sliding to well beyond saturation, sometimes a step, sometimes a sine.
      const double peak_N = level_N * rng.log_uniform(0.1, 2.0);
      axis.set_force({peak_N * rng.uniform(-1.0, 1.0), rng.chance(0.6) ? peak_N : 0.0,
                      2.0 * std::numbers::pi * rng.log_uniform(1.0, 300.0), rng.uniform(0.0, 6.0)});
      axis.advance_to(0.004 * i);
      const EnergyAudit now = axis.energy();
      throughput_J += std::fabs(now.work - last_work_J);
      last_work_J = now.work;
      ASSERT_NEAR(now.imbalance(), 0.0, 1e-9 * throughput_J) << "seed " << seed << " at " << axis.time_s();
    }
    EXPECT_GT(axis.energy().dissipated, 0.0);
    events += axis.events();
  }
  EXPECT_GT(events, 100000U);
}

// The curve through the elements, ∫₀ˣ y and its inverse use, in long double and without the bank's code.
struct PiecewiseCurve {
  std::vector<long double> k, d;
  explicit PiecewiseCurve(const MaxwellElements& bank) {
    for (std::size_t i = 0; i < bank.size(); ++i) {
      k.push_back(bank.stiffness_N_per_m(i));
      d.push_back(bank.slip_m(i));
    }
  }
  long double y(long double x) const {
    long double sum = 0.0L;
    for (std::size_t i = 0; i < k.size(); ++i) sum += k[i] * std::min(x, d[i]);
    return sum;
  }
  long double area(long double x) const {
    long double sum = 0.0L;
    for (std::size_t i = 0; i < k.size(); ++i) {
      const long double stuck = std::min(x, d[i]);
      sum += k[i] * (0.5L * stuck * stuck + d[i] * (x - stuck));
    }
    return sum;
  }
  // Starting at rest with force `force_N`, and a branch F = force − 2·y(w/2): the way w until rest again,
  // from ∫₀ʷ F dw = 0, that is force·w = 4·∫₀^{w/2} y.
  long double stopping_distance(long double force_N) const {
    long double high = d[0];
    const auto surplus = [&](long double w) { return force_N * w - 4.0L * area(0.5L * w); };
    while (surplus(high) > 0.0L) high *= 2.0L;
    long double low = 0.0L;
    for (int i = 0; i < 200; ++i) {
      const long double middle = 0.5L * (low + high);
      (surplus(middle) > 0.0L ? low : high) = middle;
    }
    return high;
  }
};

// A mass let go from x₀ on the virgin curve: each swing ends where the branch has taken up as much as it
// gave.
TEST(ExactAxis, FreeResponseTurnsWhereTheEnergyBalanceSays) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Rng rng(seed);
    MaxwellElements bank = random_bank(rng, 200);
    const PiecewiseCurve curve(bank);
    const double x0 = bank.slip_m(100) * rng.uniform(0.3, 3.0);
    bank.move_to(x0);
    LinearPart linear;
    linear.mass_kg = rng.log_uniform(1.0, 60.0);
    ExactAxis axis(linear, bank);
    axis.restart(0.0, bank, 0.0);

    long double x = x0;
    long double force = curve.y(x0);
    int direction = -1;
    for (int swing = 0; swing < 12; ++swing) {
      const long double way = curve.stopping_distance(std::fabs(force));
      x += direction * way;
      force += direction * 2.0L * curve.y(0.5L * way);
      ASSERT_TRUE(axis.advance_to_reversal(1e3));
      ASSERT_NEAR(axis.position_m(), static_cast<double>(x), 1e-9 * x0)
          << "seed " << seed << " swing " << swing;
      ASSERT_NEAR(axis.bank().force_N(), static_cast<double>(force), 1e-9 * bank.saturation_N());
      direction = -direction;
    }
    // It does not return to where it came from.
    EXPECT_GT(std::fabs(static_cast<double>(x)), 1e-3 * x0);
  }
}

TEST(ExactAxis, OneElementThatSticksIsAHarmonicOscillator) {
  const double k = 4e5;
  const double m = 10.0;
  LinearPart linear;
  linear.mass_kg = m;
  ExactAxis axis(linear, MaxwellElements({k}, {1.0}));
  axis.set_force({3.0});
  const double w = std::sqrt(k / m);
  for (int i = 1; i < 2000; ++i) {
    const double t = 0.00037 * i;
    axis.advance_to(t);
    ASSERT_NEAR(axis.position_m(), 3.0 / k * (1.0 - std::cos(w * t)), 1e-12 * 3.0 / k * (1.0 + w * t));
    ASSERT_NEAR(axis.velocity_mps(), 3.0 / k * w * std::sin(w * t), 1e-12 * 3.0 / k * w * (1.0 + w * t));
  }
}

TEST(ExactAxis, SlidingIsUniformlyAccelerated) {
  LinearPart linear;
  linear.mass_kg = 2.0;
  const double slip = 1e-6;
  ExactAxis axis(linear, MaxwellElements({1e6}, {slip}));
  axis.set_force({5.0});
  axis.advance_to(1.0);
  // Energy at the moment of slip, then constant acceleration by what the friction leaves.
  const double v_slip = std::sqrt(2.0 / 2.0 * (5.0 * slip - 0.5 * 1e6 * slip * slip));
  const double w = std::sqrt(1e6 / 2.0);
  const double t_slip = std::acos(1.0 - slip * 1e6 / 5.0) / w;
  const double left = 1.0 - t_slip;
  EXPECT_NEAR(axis.velocity_mps(), v_slip + 2.0 * left, 1e-12);
  EXPECT_NEAR(axis.position_m(), slip + v_slip * left + left * left, 1e-12);
}

TEST(ExactAxis, DampedResponseMeetsTheClosedForm) {
  LinearPart linear;
  linear.mass_kg = 3.0;
  linear.spring_N_per_m = 1200.0;
  for (const double ratio : {0.05, 0.7, 1.0, 2.5}) {
    const double w = 20.0;
    linear.viscous_N_s_per_m = 2.0 * ratio * w * linear.mass_kg;
    ExactAxis axis(linear, MaxwellElements({1e-12}, {1.0}));
    axis.set_force({6.0});
    axis.advance_to(0.3);
    const double s = ratio * w;
    double decay = std::exp(-s * 0.3) * (1.0 + s * 0.3);
    if (ratio < 1.0) {
      const double d = w * std::sqrt(1.0 - ratio * ratio);
      decay = std::exp(-s * 0.3) * (std::cos(d * 0.3) + s / d * std::sin(d * 0.3));
    } else if (ratio > 1.0) {
      const double d = w * std::sqrt(ratio * ratio - 1.0);
      decay = std::exp(-s * 0.3) * (std::cosh(d * 0.3) + s / d * std::sinh(d * 0.3));
    }
    EXPECT_NEAR(axis.position_m(), 6.0 / 1200.0 * (1.0 - decay), 1e-14) << ratio;
  }
}

TEST(ExactAxis, DoesNotDependOnHowOftenItIsAsked) {
  Rng rng(17);
  const MaxwellElements bank = random_bank(rng, 200);
  LinearPart linear;
  linear.mass_kg = 35.45;
  linear.arm_ratio = 0.2;
  linear.arm_rad_per_s = 200.0;
  ExactAxis once(linear, bank);
  ExactAxis often(linear, bank);
  const SineForce force = {0.0, 0.8 * bank.saturation_N(), 120.0, 0.3};
  once.set_force(force);
  often.set_force(force);
  once.advance_to(0.5);
  for (int i = 1; i <= 7919; ++i) often.advance_to(0.5 * i / 7919);
  EXPECT_GT(once.reversals(), 10U);
  EXPECT_NEAR(once.position_m(), often.position_m(), 1e-10 * bank.slip_m(199));
  EXPECT_NEAR(once.energy().dissipated, often.energy().dissipated, 1e-10 * once.energy().dissipated);
}

TEST(ExactAxis, RestsWhenNothingPulls) {
  LinearPart linear;
  ExactAxis axis(linear, MaxwellElements({1e5}, {1e-5}));
  axis.advance_to(10.0);
  EXPECT_EQ(axis.time_s(), 10.0);
  EXPECT_EQ(axis.position_m(), 0.0);
  EXPECT_EQ(axis.events(), 0U);
}

TEST(ExactAxis, RefusesWhatIsNotPhysical) {
  LinearPart linear;
  linear.mass_kg = 0.0;
  EXPECT_THROW(ExactAxis(linear, MaxwellElements({1.0}, {1.0})), std::invalid_argument);
  linear.mass_kg = 1.0;
  linear.viscous_N_s_per_m = -1.0;
  EXPECT_THROW(ExactAxis(linear, MaxwellElements({1.0}, {1.0})), std::invalid_argument);
  linear.viscous_N_s_per_m = 0.0;
  linear.arm_ratio = 1.0;
  EXPECT_THROW(ExactAxis(linear, MaxwellElements({1.0}, {1.0})), std::invalid_argument);
}

}  // namespace
}  // namespace slipstack::sim
