// SPDX-License-Identifier: Apache-2.0
// The bank against a plain sum of stop operators, and against the closed forms of [2].
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "sim_host/plant/friction/maxwell_elements.h"
#include "sim_host/plant/friction/virgin_curve.h"
#include "sim_host/rng.h"

namespace slipstack::sim {
namespace {

// The textbook form: every element's elongation is the old one plus the step, clamped to its slip distance.
class PlainBank {
 public:
  explicit PlainBank(const MaxwellElements& like) {
    for (std::size_t i = 0; i < like.size(); ++i) {
      stiffness_.push_back(like.stiffness_N_per_m(i));
      slip_.push_back(like.slip_m(i));
    }
    z_.assign(slip_.size(), 0.0L);
  }
  void move_to(double x_m) {
    for (std::size_t i = 0; i < z_.size(); ++i) {
      const long double d = slip_[i];
      const long double wanted = z_[i] + (static_cast<long double>(x_m) - x_);
      const long double kept = std::clamp(wanted, -d, d);
      dissipated_ += stiffness_[i] * d * std::fabs(wanted - kept);
      z_[i] = kept;
    }
    x_ = x_m;
  }
  double force() const {
    long double sum = 0.0L;
    for (std::size_t i = 0; i < z_.size(); ++i) sum += stiffness_[i] * z_[i];
    return static_cast<double>(sum);
  }
  double stored() const {
    long double sum = 0.0L;
    for (std::size_t i = 0; i < z_.size(); ++i) sum += 0.5L * stiffness_[i] * z_[i] * z_[i];
    return static_cast<double>(sum);
  }
  double dissipated() const { return static_cast<double>(dissipated_); }

 private:
  std::vector<long double> stiffness_, slip_, z_;
  long double x_ = 0.0L;
  long double dissipated_ = 0.0L;
};

VirginCurve rational(double level_N, double length_m) {
  return VirginCurve({{CurveKind::kRational, level_N, length_m, 1.0}});
}

VirginCurve random_curve(Rng& rng) {
  std::vector<CurveTerm> terms(1 + rng.below(3));
  for (CurveTerm& term : terms) {
    term.kind = rng.pick({CurveKind::kExponential, CurveKind::kRational, CurveKind::kStretched});
    term.level_N = rng.log_uniform(1.0, 10.0);
    term.length_m = rng.log_uniform(1e-6, 2e-5);
    if (term.kind == CurveKind::kStretched) term.exponent = rng.uniform(0.5, 1.0);
  }
  return VirginCurve(std::move(terms));
}

TEST(MaxwellElements, EqualsAPlainSumOfStopOperators) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Rng rng(seed);
    const VirginCurve curve = random_curve(rng);
    MaxwellElements bank = MaxwellElements::sample(curve, 1 + rng.below(60));
    PlainBank plain(bank);
    const double reach = 3.0 * curve.travel_m();
    double x = 0.0;
    for (int i = 0; i < 20000; ++i) {
      // Steps from far below the first slip distance to several travels.
      x = std::clamp(x + rng.uniform(-1.0, 1.0) * reach * std::pow(10.0, rng.uniform(-5.0, 0.0)), -reach,
                     reach);
      bank.move_to(x);
      plain.move_to(x);
      ASSERT_NEAR(bank.force_N(), plain.force(), 1e-9 * curve.saturation_N())
          << "seed " << seed << " step " << i;
    }
    EXPECT_NEAR(bank.stored_J(), plain.stored(), 1e-9 * plain.stored() + 1e-20);
    EXPECT_NEAR(bank.dissipated_J(), plain.dissipated(), 1e-10 * plain.dissipated());
  }
}

TEST(MaxwellElements, ForecastsTheForceWithoutMoving) {
  Rng rng(11);
  MaxwellElements bank = MaxwellElements::sample(random_curve(rng), 50);
  for (int i = 0; i < 20000; ++i) {
    const double x = bank.position_m() + rng.normal() * 3e-6;
    const double before = bank.force_N();
    const double forecast = bank.force_after_N(x);
    ASSERT_EQ(bank.force_N(), before);
    bank.move_to(x);
    ASSERT_NEAR(bank.force_N(), forecast, 1e-11);
  }
}

TEST(MaxwellElements, FollowsItsVirginCurve) {
  Rng rng(5);
  for (int trial = 0; trial < 20; ++trial) {
    const VirginCurve curve = random_curve(rng);
    MaxwellElements bank = MaxwellElements::sample(curve, 200);
    double worst = 0.0;
    for (double x = curve.travel_m() * 0.01; x < 3.0 * curve.travel_m(); x *= 1.07) {
      bank.move_to(x);
      worst = std::max(worst, std::fabs(bank.force_N() - curve.force_N(x)) / curve.saturation_N());
    }
    // 200 elements sample a smooth curve: neither exact nor off by more than a thousandth.
    EXPECT_LT(worst, 1e-3);
    EXPECT_GT(worst, 1e-9);
  }
}

TEST(MaxwellElements, ClosedLoopsReturnAndInnerLoopsAreForgotten) {
  MaxwellElements bank = MaxwellElements::sample(rational(5.0, 2e-6), 200);
  bank.move_to(6e-6);
  bank.move_to(-4e-6);
  bank.move_to(3e-6);
  const double force = bank.force_N();
  MaxwellElements straight = bank;
  bank.move_to(1e-6);
  bank.move_to(2e-6);
  bank.move_to(-1e-6);
  bank.move_to(3e-6);
  EXPECT_NEAR(bank.force_N(), force, 1e-13);
  bank.move_to(5e-6);
  straight.move_to(5e-6);
  EXPECT_NEAR(bank.force_N(), straight.force_N(), 1e-13);
}

TEST(MaxwellElements, WorkIsStoredOrDissipated) {
  Rng rng(3);
  MaxwellElements bank = MaxwellElements::sample(random_curve(rng), 100);
  double work = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const double target = rng.normal() * 8e-6;
    const int direction = target > bank.position_m() ? 1 : -1;
    // Between slips the force is linear in place, so the trapezium is exact.
    while (bank.position_m() != target) {
      const double slip = bank.next_slip_m(direction);
      const double next = direction * (slip - target) < 0.0 ? slip : target;
      const double x = bank.position_m();
      const double force = bank.force_N();
      bank.move_to(next);
      work += 0.5 * (force + bank.force_N()) * (next - x);
    }
  }
  EXPECT_NEAR(work, bank.stored_J() + bank.dissipated_J(), 1e-12 * work);
  EXPECT_GT(bank.dissipated_J(), 0.5 * work);
}

// One loop between ±A, after the first quarter.
double loop_area_J(MaxwellElements& bank, double amplitude_m) {
  bank.reset(0.0);
  bank.move_to(amplitude_m);
  bank.move_to(-amplitude_m);
  bank.move_to(amplitude_m);
  const double before = bank.dissipated_J();
  bank.move_to(-amplitude_m);
  bank.move_to(amplitude_m);
  return bank.dissipated_J() - before;
}

// [2]: loop area = 8·∫₀ᴬ y dx − 4·A·y(A); damping ratio at resonance = area/(2π·A·y(A)).
TEST(MaxwellElements, LoopAreaMeetsTheClosedFormOfARationalCurve) {
  constexpr double kLevel = 2.0;
  constexpr double kLength = 2e-6;
  const VirginCurve curve = rational(kLevel, kLength);
  double last_error = 1.0;
  for (const std::size_t elements : {50UL, 200UL, 800UL}) {
    MaxwellElements bank = MaxwellElements::sample(curve, elements);
    double worst = 0.0;
    for (const double amplitude : {0.5e-6, 1e-6, 3e-6, 1e-5, 4e-5}) {
      // ∫y dx = h₀·A²/(A+δ), hence the area 4·h₀·A²·δ... reduces ζᵣ to (2/π)·A/(A + 2δ).
      const double y = curve.force_N(amplitude);
      const double damping = loop_area_J(bank, amplitude) / (2.0 * std::numbers::pi * amplitude * y);
      const double expected = 2.0 / std::numbers::pi * amplitude / (amplitude + 2.0 * kLength);
      worst = std::max(worst, std::fabs(damping / expected - 1.0));
    }
    EXPECT_LT(worst, 20.0 / static_cast<double>(elements * elements)) << elements;
    EXPECT_LT(worst, 0.2 * last_error) << "no second-order convergence at " << elements;
    last_error = worst;
  }
}

TEST(MaxwellElements, LoopAreaOfThePiecewiseLinearCurveIsExact) {
  Rng rng(8);
  MaxwellElements bank = MaxwellElements::sample(random_curve(rng), 40);
  for (int trial = 0; trial < 50; ++trial) {
    const double amplitude = rng.log_uniform(1e-7, 1e-4);
    // ∫₀ᴬ y dx of Σ kᵢ·min(x, dᵢ), and y(A).
    double integral = 0.0;
    double y = 0.0;
    for (std::size_t i = 0; i < bank.size(); ++i) {
      const double k = bank.stiffness_N_per_m(i);
      const double d = bank.slip_m(i);
      const double stuck = std::min(amplitude, d);
      integral += k * (0.5 * stuck * stuck + d * (amplitude - stuck));
      y += k * stuck;
    }
    const double expected = 8.0 * integral - 4.0 * amplitude * y;
    EXPECT_NEAR(loop_area_J(bank, amplitude), expected, 1e-11 * (expected + amplitude * y));
  }
}

TEST(MaxwellElements, RefusesWhatIsNotABank) {
  EXPECT_THROW(MaxwellElements({1.0}, {1e-6, 2e-6}), std::invalid_argument);
  EXPECT_THROW(MaxwellElements({-1.0}, {1e-6}), std::invalid_argument);
  EXPECT_THROW(MaxwellElements({1.0, 1.0}, {2e-6, 1e-6}), std::invalid_argument);
  EXPECT_THROW(MaxwellElements({1.0}, {0.0}), std::invalid_argument);
  EXPECT_THROW(VirginCurve({{CurveKind::kStretched, 1.0, 1e-6, 1.3}}), std::invalid_argument);
  EXPECT_THROW(VirginCurve({{CurveKind::kRational, -1.0, 1e-6, 1.0}}), std::invalid_argument);
}

}  // namespace
}  // namespace slipstack::sim
