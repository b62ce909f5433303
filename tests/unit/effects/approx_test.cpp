// SPDX-License-Identifier: Apache-2.0
#include "firmware/effects/numerics/approx.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>

namespace slipstack {
namespace {

// Distance from 1 to the next float.
constexpr double kU = 1.1920928955078125e-7;

/// The largest of a quantity over a scan, held to its promise from both sides: an approximation that becomes
/// much better than the header says has changed as well.
class Worst {
 public:
  void take(double value) { worst_ = value > worst_ ? value : worst_; }
  void expect_within(double promise) const {
    EXPECT_LT(worst_, promise);
    EXPECT_GT(worst_, 0.25 * promise);
  }
  double value() const { return worst_; }

 private:
  double worst_ = 0.0;
};

/// Visits a dense grid over [low, high], its ends, and as many random points.
template <class Real, class Visit>
void scan(double low, double high, Visit visit) {
  constexpr int kPoints = 100'000;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> anywhere(low, high);
  for (int i = 0; i <= kPoints; ++i) {
    visit(static_cast<Real>(low + (high - low) * i / kPoints));
    visit(static_cast<Real>(anywhere(random)));
  }
}

/// The same, evenly in the logarithm, for 0 < low < high.
template <class Real, class Visit>
void log_scan(double low, double high, Visit visit) {
  scan<double>(std::log(low), std::log(high), [&](double x) { visit(static_cast<Real>(std::exp(x))); });
}

double relative_error(double is, long double should) {
  return std::abs(static_cast<double>((static_cast<long double>(is) - should) / should));
}

TEST(Approx, Exp2Double) {
  Worst worst;
  scan<double>(-100.0, 100.0, [&](double x) {
    worst.take(relative_error(approx::exp2(x), std::exp2(static_cast<long double>(x))));
  });
  worst.expect_within(8e-9);
}

TEST(Approx, Exp2Float) {
  Worst worst;
  scan<float>(-100.0, 100.0, [&](float x) {
    worst.take(relative_error(static_cast<double>(approx::exp2(x)), std::exp2(static_cast<long double>(x))));
  });
  worst.expect_within(kU);
}

TEST(Approx, Exp2OfIntegersIsExact) {
  for (int n = -100; n <= 100; ++n) {
    EXPECT_EQ(approx::exp2(static_cast<double>(n)), std::ldexp(1.0, n));
    EXPECT_EQ(approx::exp2(static_cast<float>(n)), std::ldexp(1.0F, n));
  }
}

// Beyond its range, and for what is no number, it stays finite: nothing that comes after is poisoned.
TEST(Approx, Exp2IsBounded) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(approx::exp2(1e9), std::ldexp(1.0, 100));
  EXPECT_EQ(approx::exp2(infinity), std::ldexp(1.0, 100));
  EXPECT_EQ(approx::exp2(-1e9), std::ldexp(1.0, -100));
  EXPECT_EQ(approx::exp2(-infinity), std::ldexp(1.0, -100));
  EXPECT_EQ(approx::exp2(std::nan("")), std::ldexp(1.0, -100));
  EXPECT_EQ(approx::exp2(std::nanf("")), std::ldexp(1.0F, -100));
}

TEST(Approx, ExpDouble) {
  Worst worst;
  scan<double>(-69.0, 69.0, [&](double x) {
    worst.take(relative_error(approx::exp(x), std::exp(static_cast<long double>(x))));
  });
  worst.expect_within(8e-9);
}

TEST(Approx, ExpFloat) {
  Worst worst;
  for (const double reach : {0.5, 5.0, 69.0}) {
    scan<float>(-reach, reach, [&](float x) {
      const double error =
          relative_error(static_cast<double>(approx::exp(x)), std::exp(static_cast<long double>(x)));
      worst.take(error / (1.2 + 0.65 * std::abs(static_cast<double>(x))));
    });
  }
  worst.expect_within(kU);
}

// The promise is relative to the small result: this is what std::expm1 is for.
TEST(Approx, ExpMinusOneDouble) {
  Worst worst;
  for (const double reach : {1e-12, 1e-6, 1e-2, 1.0, 69.0}) {
    scan<double>(-reach, reach, [&](double x) {
      if (x == 0.0) {
        EXPECT_EQ(approx::exp_minus_one(x), 0.0);
      } else {
        worst.take(relative_error(approx::exp_minus_one(x), std::expm1(static_cast<long double>(x))));
      }
    });
  }
  worst.expect_within(2.5e-8);
}

TEST(Approx, ExpMinusOneFloat) {
  Worst worst;
  for (const double reach : {1e-12, 1e-6, 1e-2, 1.0, 69.0}) {
    scan<float>(-reach, reach, [&](float x) {
      if (x == 0.0F) return;
      const double error = relative_error(static_cast<double>(approx::exp_minus_one(x)),
                                          std::expm1(static_cast<long double>(x)));
      worst.take(error / (2.5 + 0.65 * std::abs(static_cast<double>(x))));
    });
  }
  worst.expect_within(kU);
}

TEST(Approx, Log2Double) {
  Worst worst;
  const auto visit = [&](double x) {
    if (x != 1.0) worst.take(relative_error(approx::log2(x), std::log2(static_cast<long double>(x))));
  };
  log_scan<double>(1e-300, 1e300, visit);
  log_scan<double>(0.5, 2.0, visit);
  worst.expect_within(2.5e-9);
}

TEST(Approx, Log2Float) {
  Worst worst;
  const auto visit = [&](float x) {
    if (x == 1.0F) return;
    worst.take(relative_error(static_cast<double>(approx::log2(x)), std::log2(static_cast<long double>(x))));
  };
  log_scan<float>(1.2e-38, 3.4e38, visit);
  log_scan<float>(0.5, 2.0, visit);
  worst.expect_within(2.5 * kU);
}

TEST(Approx, Log2OfPowersOfTwoIsExact) {
  for (int n = -126; n <= 127; ++n) {
    EXPECT_EQ(approx::log2(std::ldexp(1.0F, n)), static_cast<float>(n));
    EXPECT_EQ(approx::log2(std::ldexp(1.0, n)), static_cast<double>(n));
  }
}

template <class Real>
double worst_power(double floor, double slope) {
  Worst worst;
  for (const double e : {0.4, 0.7, 1.0, 2.0, 3.0}) {
    const auto exponent = static_cast<Real>(e);
    log_scan<Real>(1e-9, 1e9, [&](Real x) {
      const long double should = std::pow(static_cast<long double>(x), static_cast<long double>(exponent));
      const double error = relative_error(static_cast<double>(approx::power(x, exponent)), should);
      worst.take(error / (floor + slope * std::abs(static_cast<double>(std::log2(should)))));
    });
  }
  return worst.value();
}

TEST(Approx, Power) {
  EXPECT_LT(worst_power<double>(1.0, 0.0), 1e-8);
  EXPECT_GT(worst_power<double>(1.0, 0.0), 2e-9);
  EXPECT_LT(worst_power<float>(2.0, 0.6), kU);
  EXPECT_GT(worst_power<float>(2.0, 0.6), 0.5 * kU);
}

TEST(Approx, PowerOfZero) {
  EXPECT_LT(approx::power(0.0, 0.4), 1.1e-12);
  EXPECT_GE(approx::power(0.0, 0.4), 0.0);
  EXPECT_LT(approx::power(0.0F, 3.0F), 1e-29F);
}

/// Sine and cosine of 2 pi x without rounding 2 pi x.
struct Exact {
  explicit Exact(double cycles) {
    const double part = cycles - std::round(cycles);
    const long double angle = 2.0L * std::numbers::pi_v<long double> * static_cast<long double>(part);
    sine = static_cast<double>(std::sin(angle));
    cosine = static_cast<double>(std::cos(angle));
  }
  double sine;
  double cosine;
};

template <class Real>
double worst_sin_cos(double reach) {
  Worst worst;
  scan<Real>(-reach, reach, [&](Real cycles) {
    const Exact exact(static_cast<double>(cycles));
    const auto wave = approx::sin_cos_of_cycles(cycles);
    worst.take(std::abs(static_cast<double>(wave.sin) - exact.sine));
    worst.take(std::abs(static_cast<double>(wave.cos) - exact.cosine));
  });
  return worst.value();
}

TEST(Approx, SineAndCosine) {
  for (const double reach : {0.6, 10.0, 1e4, 536870911.0}) {
    EXPECT_LT(worst_sin_cos<double>(reach), 2.5e-8) << reach;
    EXPECT_GT(worst_sin_cos<double>(reach), 2.0e-8) << reach;
  }
  for (const double reach : {0.6, 10.0, 1e4, 2097151.0}) {
    EXPECT_LT(worst_sin_cos<float>(reach), 0.8 * kU) << reach;
    EXPECT_GT(worst_sin_cos<float>(reach), 0.4 * kU) << reach;
  }
}

TEST(Approx, SineAndCosineOfQuartersAreExact) {
  for (int quarter = -9; quarter <= 9; ++quarter) {
    const auto wave = approx::sin_cos_of_cycles(0.25 * quarter);
    const int phase = ((quarter % 4) + 4) % 4;
    EXPECT_EQ(wave.sin, phase == 1 ? 1.0 : phase == 3 ? -1.0 : 0.0) << quarter;
    EXPECT_EQ(wave.cos, phase == 0 ? 1.0 : phase == 2 ? -1.0 : 0.0) << quarter;
  }
}

// The series of a small angle is as good as the angle: a ripple starts smoothly at x = 0.
TEST(Approx, SmallSinesAreRelativelyExact) {
  log_scan<double>(1e-12, 1e-3, [&](double cycles) {
    const double should = std::sin(2.0 * std::numbers::pi * cycles);
    EXPECT_NEAR(approx::sin_cos_of_cycles(cycles).sin / should, 1.0, 1e-14);
  });
}

TEST(Approx, SquareRoot) {
  log_scan<float>(1.2e-38, 3.4e38, [](float a) {
    const float should = std::sqrt(a);
    const float is = approx::square_root(a);
    ASSERT_TRUE(is == should || is == std::nextafter(should, 0.0F) ||
                is == std::nextafter(should, std::numeric_limits<float>::infinity()))
        << a;
  });
  log_scan<double>(std::ldexp(1.0, -200), std::ldexp(1.0, 200),
                   [](double a) { ASSERT_NEAR(approx::square_root(a) / std::sqrt(a), 1.0, 2.3e-16) << a; });
  EXPECT_EQ(approx::square_root(0.0), 0.0);
  EXPECT_EQ(approx::square_root(-1.0F), 0.0F);
  EXPECT_EQ(approx::square_root(std::nan("")), 0.0);
  EXPECT_EQ(approx::square_root(0.25), 0.5);
}

TEST(Approx, FloorToInt) {
  scan<double>(-1000.0, 1000.0, [](double x) {
    ASSERT_EQ(approx::floor_to_int(x), static_cast<std::int32_t>(std::floor(x))) << x;
    const auto f = static_cast<float>(x);
    ASSERT_EQ(approx::floor_to_int(f), static_cast<std::int32_t>(std::floor(f))) << x;
  });
  for (int n = -5; n <= 5; ++n) {
    EXPECT_EQ(approx::floor_to_int(static_cast<double>(n)), n);
    EXPECT_EQ(approx::floor_to_int(std::nextafter(static_cast<double>(n), -10.0)), n - 1);
  }
  EXPECT_EQ(approx::floor_to_int(-2147483647.5), std::numeric_limits<std::int32_t>::min());
  EXPECT_EQ(approx::floor_to_int(2147483647.5), std::numeric_limits<std::int32_t>::max());
}

TEST(Approx, ClampMakesEverythingFitForUse) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(approx::clamp(0.5, -1.0, 1.0), 0.5);
  EXPECT_EQ(approx::clamp(-1.5, -1.0, 1.0), -1.0);
  EXPECT_EQ(approx::clamp(1.5, -1.0, 1.0), 1.0);
  EXPECT_EQ(approx::clamp(infinity, -1.0, 1.0), 1.0);
  EXPECT_EQ(approx::clamp(-infinity, -1.0, 1.0), -1.0);
  EXPECT_EQ(approx::clamp(std::nan(""), -1.0, 1.0), -1.0);
  EXPECT_EQ(approx::clamp(std::nanf(""), 2.0F, 3.0F), 2.0F);
}

TEST(Approx, Absolute) {
  EXPECT_EQ(approx::absolute(-2.5), 2.5);
  EXPECT_EQ(approx::absolute(2.5F), 2.5F);
  EXPECT_EQ(approx::absolute(0.0), 0.0);
}

TEST(Approx, PowersOfTwo) {
  for (int n = -120; n <= 120; ++n) {
    EXPECT_EQ(approx::power_of_two<float>(n), std::ldexp(1.0F, n));
    EXPECT_EQ(approx::power_of_two<double>(n), std::ldexp(1.0, n));
  }
}

// All of it is arithmetic that the compiler can do.
static_assert(approx::exp(0.0F) == 1.0F);
static_assert(approx::square_root(4.0) == 2.0);
static_assert(approx::sin_cos_of_cycles(0.0F).cos == 1.0F);

TEST(IsFinite, ByTheExponent) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float x : {0.0F, -0.0F, 1e-45F, -3.4e38F, 1.0F}) EXPECT_TRUE(approx::is_finite(x));
  for (const float x : {kInfinity, -kInfinity, std::nanf("")}) EXPECT_FALSE(approx::is_finite(x));
}

// Host and target agree only while no product is fused with a sum.
TEST(Arithmetic, RoundsAProductBeforeItIsAdded) {
  // (1 + u)^2 is no float: fused, what is left of it would be u^2.
  volatile float next = 1.0F + std::numeric_limits<float>::epsilon();
  const float factor = next;
  const float rounded = 1.0F + 2.0F * (factor - 1.0F);
  EXPECT_EQ(factor * factor - rounded, 0.0F);
  EXPECT_EQ(rounded - factor * factor, 0.0F);
}

}  // namespace
}  // namespace slipstack
