// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/zero_phase.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

namespace slipstack::workbench {
namespace {

constexpr double kFilterRate_Hz = 1000.0;

/// Response at a frequency, computed from the definition.
std::complex<double> response(const std::vector<double>& taps, double frequency_Hz) {
  const double turn = 2.0 * std::numbers::pi * frequency_Hz / kFilterRate_Hz;
  const std::size_t middle = taps.size() / 2;
  const auto half = static_cast<double>(middle);
  std::complex<double> sum;
  for (std::size_t k = 0; k < taps.size(); ++k) {
    sum += taps[k] * std::polar(1.0, -turn * (static_cast<double>(k) - half));
  }
  return sum;
}

const std::vector<double> kCutoffs_Hz{2.0, 7.3, 20.0, 50.0, 133.0, 250.0, 300.0};

TEST(LowPass, IsSymmetricAndPassesAConstant) {
  for (const double cutoff : kCutoffs_Hz) {
    const std::vector<double> taps = low_pass_taps(cutoff, kFilterRate_Hz);
    ASSERT_EQ(taps.size() % 2, 1u);
    for (std::size_t k = 0; k < taps.size(); ++k) EXPECT_NEAR(taps[k], taps[taps.size() - 1 - k], 1e-16);
    EXPECT_NEAR(response(taps, 0.0).real(), 1.0, 1e-14);
  }
}

// Passband, -6 dB point and stopband as the header states them, at every frequency.
TEST(LowPass, FulfilsItsSpecification) {
  double flatness = 0.0;
  double leakage = 0.0;
  for (const double cutoff : kCutoffs_Hz) {
    const std::vector<double> taps = low_pass_taps(cutoff, kFilterRate_Hz);
    EXPECT_NEAR(std::abs(response(taps, cutoff)), 0.5, 0.01) << cutoff;
    for (double share = 0.0; share <= 0.5; share += 0.005) {
      flatness = std::max(flatness, std::abs(response(taps, share * cutoff).real() - 1.0));
    }
    for (double f = 1.5 * cutoff; f <= 0.5 * kFilterRate_Hz; f += 0.02 * cutoff) {
      leakage = std::max(leakage, std::abs(response(taps, f)));
    }
  }
  EXPECT_LT(flatness, 1e-3);
  EXPECT_GT(flatness, 1e-5);
  EXPECT_LT(leakage, std::pow(10.0, -70.0 / 20.0));
  EXPECT_GT(leakage, 1e-6);
}

TEST(LowPass, HasNoPhase) {
  const std::vector<double> taps = low_pass_taps(40.0, kFilterRate_Hz);
  for (double f = 0.0; f < 500.0; f += 1.7) EXPECT_NEAR(response(taps, f).imag(), 0.0, 1e-14);
}

// Parseval: the sum of squares is the mean of the squared response.
TEST(LowPass, NoiseGainIsThePowerOfTheResponse) {
  for (const double cutoff : kCutoffs_Hz) {
    const std::vector<double> taps = low_pass_taps(cutoff, kFilterRate_Hz);
    constexpr int kPoints = 4000;  // more than taps, so that nothing is aliased
    double power = 0.0;
    for (int i = 0; i < kPoints; ++i) power += std::norm(response(taps, kFilterRate_Hz * i / kPoints));
    EXPECT_NEAR(noise_gain(taps), power / kPoints, 1e-9 * noise_gain(taps)) << cutoff;
  }
}

std::vector<double> random_signal(std::uint64_t seed, std::size_t count) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> signal(count);
  for (double& value : signal) value = normal(random);
  return signal;
}

TEST(Filter, IsTheSumOfShiftedTaps) {
  const std::vector<double> signal = random_signal(1, 300);
  const std::vector<double> taps{0.1, -0.2, 0.7, 0.3, 0.1};
  const std::vector<double> out = filter_all(signal, taps);
  const auto at = [&](int i) { return signal[static_cast<std::size_t>(std::clamp(i, 0, 299))]; };
  for (int i = 0; i < 300; ++i) {
    const double should = 0.1 * at(i - 2) - 0.2 * at(i - 1) + 0.7 * at(i) + 0.3 * at(i + 1) + 0.1 * at(i + 2);
    EXPECT_NEAR(out[static_cast<std::size_t>(i)], should, 1e-15) << i;
  }
}

// Each sum in the order of the taps, however many are made side by side: the last bit does not depend on
// where in the signal a sample is.
TEST(Filter, IsTheSameBitForBitWhereverASampleIs) {
  const std::vector<double> taps = random_signal(3, 21);
  for (const std::size_t count : {1U, 20U, 21U, 36U, 37U, 38U, 100U}) {
    const std::vector<double> signal = random_signal(4 + count, count);
    const std::vector<double> out = filter_all(signal, taps);
    const auto last = static_cast<std::ptrdiff_t>(count) - 1;
    for (std::ptrdiff_t i = 0; i <= last; ++i) {
      double sum = 0.0;
      for (std::ptrdiff_t k = 0; k < 21; ++k)
        sum += taps[static_cast<std::size_t>(k)] *
               signal[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i - 10 + k, 0, last))];
      EXPECT_EQ(out[static_cast<std::size_t>(i)], sum) << count << ' ' << i;
    }
  }
}

TEST(Filter, PassesAConstantUpToTheEnds) {
  const std::vector<double> out =
      filter_all(std::vector<double>(50, 3.25), low_pass_taps(5.0, kFilterRate_Hz));
  for (const double value : out) EXPECT_NEAR(value, 3.25, 1e-13);
}

TEST(Filter, TwiceIsTheConvolvedFilterOnce) {
  const std::vector<double> signal = random_signal(2, 2000);
  const std::vector<double> a = low_pass_taps(60.0, kFilterRate_Hz);
  const std::vector<double> b = low_pass_taps(110.0, kFilterRate_Hz);
  const std::vector<double> twice = filter_all(filter_all(signal, a), b);
  const std::vector<double> once = filter_all(signal, convolve(a, b));
  for (std::size_t i = 200; i + 200 < signal.size(); ++i) EXPECT_NEAR(twice[i], once[i], 1e-13);
}

TEST(Convolve, MultipliesPolynomials) {
  EXPECT_EQ(convolve(std::vector<double>{1.0, 2.0}, std::vector<double>{3.0, -1.0, 4.0}),
            (std::vector<double>{3.0, 5.0, 2.0, 8.0}));
}

// Five-point differences are exact for polynomials of degree four (first derivative) and five (second).
TEST(Derivatives, AreExactOnPolynomials) {
  constexpr double kRate = 50.0;
  const auto t_at = [](std::size_t i) { return (static_cast<double>(i) - 50.0) / kRate; };
  std::vector<double> quartic, slope, quintic, curvature;
  for (std::size_t i = 0; i < 100; ++i) {
    const double t = t_at(i);
    quartic.push_back(1.0 + t * (2.0 + t * (-3.0 + t * (0.5 + t * 4.0))));
    slope.push_back(2.0 + t * (-6.0 + t * (1.5 + t * 16.0)));
    quintic.push_back(quartic.back() + 2.0 * std::pow(t, 5.0));
    curvature.push_back(-6.0 + t * (3.0 + t * (48.0 + t * 40.0)));
  }
  const std::vector<double> first = first_derivative(quartic, kRate);
  const std::vector<double> second = second_derivative(quintic, kRate);
  for (std::size_t i = 2; i + 2 < 100; ++i) {
    EXPECT_NEAR(first[i], slope[i], 1e-11);
    EXPECT_NEAR(second[i], curvature[i], 1e-9);
  }
}

// Fourth order: half the step gives a sixteenth of the error. The errors of a sine are w^5/30 and w^6/90 h^4.
TEST(Derivatives, AreOfFourthOrder) {
  const auto error = [](double rate) {
    const double w = 2.0 * std::numbers::pi * 3.0;
    std::vector<double> wave;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rate); ++i) {
      wave.push_back(std::sin(w * static_cast<double>(i) / rate));
    }
    const std::vector<double> first = first_derivative(wave, rate);
    const std::vector<double> second = second_derivative(wave, rate);
    double worst_first = 0.0;
    double worst_second = 0.0;
    for (std::size_t i = 2; i + 2 < wave.size(); ++i) {
      const double t = static_cast<double>(i) / rate;
      worst_first = std::max(worst_first, std::abs(first[i] - w * std::cos(w * t)));
      worst_second = std::max(worst_second, std::abs(second[i] + w * w * std::sin(w * t)));
    }
    const double h4 = std::pow(rate, -4.0);
    EXPECT_NEAR(worst_first / (std::pow(w, 5.0) * h4 / 30.0), 1.0, 0.03) << rate;
    EXPECT_NEAR(worst_second / (std::pow(w, 6.0) * h4 / 90.0), 1.0, 0.03) << rate;
    return worst_first;
  };
  EXPECT_NEAR(error(200.0) / error(400.0), 16.0, 0.5);
}

TEST(Derivatives, AssumeAStandstillAtTheEnds) {
  const std::vector<double> still(20, 7.0);
  for (const double value : first_derivative(still, 10.0)) EXPECT_EQ(value, 0.0);
  for (const double value : second_derivative(still, 10.0)) EXPECT_EQ(value, 0.0);
}

}  // namespace
}  // namespace slipstack::workbench
