// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/spectrum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace slipstack::workbench {
namespace {

constexpr double kRate_Hz = 2000.0;

std::vector<double> white(std::uint64_t seed, std::size_t count, double sigma) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, sigma);
  std::vector<double> signal(count);
  for (double& value : signal) value = normal(random);
  return signal;
}

std::vector<double> sine(std::size_t count, double frequency_Hz, double amplitude) {
  std::vector<double> signal(count);
  for (std::size_t i = 0; i < count; ++i) {
    signal[i] =
        amplitude * std::sin(2.0 * std::numbers::pi * frequency_Hz * static_cast<double>(i) / kRate_Hz + 0.3);
  }
  return signal;
}

double power(const Spectrum& spectrum, double low_Hz, double high_Hz) {
  const double step_Hz = spectrum.frequency_Hz[1];
  double sum = 0.0;
  for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
    if (spectrum.frequency_Hz[k] >= low_Hz && spectrum.frequency_Hz[k] <= high_Hz) {
      sum += spectrum.density[k] * step_Hz;
    }
  }
  return sum;
}

TEST(Spectrum, OfWhiteNoiseIsFlatAtItsVariance) {
  constexpr double kSigma = 0.7;
  const Spectrum spectrum = power_spectrum(white(1, 400'000, kSigma), kRate_Hz, 256);
  const double should = 2.0 * kSigma * kSigma / kRate_Hz;
  double mean = 0.0;
  double spread = 0.0;
  // The first two bins lack power, because the mean is removed; each of the others scatters by
  // 1/sqrt(segments).
  for (std::size_t k = 2; k < spectrum.density.size(); ++k) {
    mean += spectrum.density[k];
    spread += std::pow(spectrum.density[k] / should - 1.0, 2.0);
  }
  const auto bins = static_cast<double>(spectrum.density.size() - 2);
  EXPECT_NEAR(mean / bins / should, 1.0, 0.01);
  // Half-overlapping Hann segments: the variance is 1.06 / segments (Welch 1967).
  const double segments = 400'000.0 / 128.0;
  EXPECT_NEAR(std::sqrt(spread / bins) / std::sqrt(1.06 / segments), 1.0, 0.25);
}

TEST(Spectrum, OfASineHoldsHalfItsSquaredAmplitude) {
  for (const double frequency : {125.0, 128.9, 400.0, 901.3}) {
    const Spectrum spectrum = power_spectrum(sine(60'000, frequency, 3.0), kRate_Hz, 512);
    const double near = power(spectrum, frequency - 12.0, frequency + 12.0);
    EXPECT_NEAR(near / 4.5, 1.0, 0.01) << frequency;
    EXPECT_LT(power(spectrum, 0.0, frequency - 30.0) + power(spectrum, frequency + 30.0, 1000.0), 4.5e-3);
    const auto peak = std::max_element(spectrum.density.begin(), spectrum.density.end());
    const double at = spectrum.frequency_Hz[static_cast<std::size_t>(peak - spectrum.density.begin())];
    EXPECT_NEAR(at, frequency, 0.5 * kRate_Hz / 512.0 + 1e-9);
  }
}

TEST(Spectrum, RemovesTheMean) {
  std::vector<double> signal = white(2, 20'000, 0.01);
  for (double& value : signal) value += 1000.0;
  const Spectrum spectrum = power_spectrum(signal, kRate_Hz, 256);
  EXPECT_LT(spectrum.density[0], 10.0 * spectrum.density[50]);
}

TEST(Spectrum, ListsTheFrequenciesOfItsBins) {
  const Spectrum spectrum = power_spectrum(white(3, 1000, 1.0), kRate_Hz, 128);
  ASSERT_EQ(spectrum.frequency_Hz.size(), 64u);
  ASSERT_EQ(spectrum.density.size(), 64u);
  for (std::size_t k = 0; k < 64; ++k) {
    EXPECT_DOUBLE_EQ(spectrum.frequency_Hz[k], static_cast<double>(k) * kRate_Hz / 128.0);
    EXPECT_GE(spectrum.density[k], 0.0);
  }
}

TEST(Spectrum, IsEmptyWithoutAWholeSegment) {
  EXPECT_TRUE(power_spectrum(white(4, 127, 1.0), kRate_Hz, 128).density.empty());
  EXPECT_FALSE(power_spectrum(white(4, 128, 1.0), kRate_Hz, 128).density.empty());
  EXPECT_TRUE(power_spectrum({}, kRate_Hz, 128).density.empty());
}

// A delay by a sample with noise of the same size added: gain, phase, coherence and their scatter are known.
TEST(CrossSpectrum, OfADelayWithNoise) {
  constexpr std::size_t kSegment = 128;
  CrossSpectrum spectrum(kRate_Hz, kSegment);
  const std::vector<double> input = white(5, 100'001, 1.0);
  const std::vector<double> noise = white(6, 100'001, 1.0);
  std::vector<double> output(input.size());
  for (std::size_t i = 1; i < input.size(); ++i) output[i] = 2.0 * input[i - 1] + 2.0 * noise[i];
  // In two stretches: nothing reaches from one to the other.
  const std::span<const double> x(input), y(output);
  spectrum.add(x.first(60'000), y.first(60'000));
  spectrum.add(x.subspan(60'000), y.subspan(60'000));
  spectrum.add(x.first(kSegment - 1), y.first(kSegment - 1));
  EXPECT_EQ(spectrum.segments(), (60'000 - kSegment) / 64 + 1 + (40'001 - kSegment) / 64 + 1);
  double squared = 0.0;
  double expected = 0.0;
  for (std::size_t k = 2; k < spectrum.bins(); ++k) {
    const double turn = -2.0 * std::numbers::pi * spectrum.frequency_Hz(k) / kRate_Hz;
    const std::complex<double> error = spectrum.response(k) / std::polar(2.0, turn) - 1.0;
    EXPECT_LT(std::abs(error), 0.12) << k;
    EXPECT_NEAR(spectrum.coherence(k), 0.5, 0.08) << k;
    squared += error.real() * error.real();
    expected += spectrum.response_deviation(k) * spectrum.response_deviation(k);
  }
  EXPECT_NEAR(std::sqrt(squared / expected), 1.0, 0.25);
}

TEST(CrossSpectrum, UnrelatedSignalsExceedTheChanceLevelAsOftenAsItSays) {
  int above = 0;
  int all = 0;
  for (std::uint64_t seed = 10; seed < 60; ++seed) {
    CrossSpectrum spectrum(kRate_Hz, 128);
    spectrum.add(white(seed, 2'000, 1.0), white(seed + 1000, 2'000, 1.0));
    for (std::size_t k = 2; k < spectrum.bins(); ++k, ++all) {
      above += spectrum.coherence(k) > spectrum.chance_coherence(0.05);
    }
  }
  EXPECT_NEAR(static_cast<double>(above) / all, 0.05, 0.015);
  EXPECT_EQ(CrossSpectrum(kRate_Hz, 128).chance_coherence(0.05), 1.0);
}

}  // namespace
}  // namespace slipstack::workbench
