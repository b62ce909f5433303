// SPDX-License-Identifier: Apache-2.0
// The periodic sweep that excites a loop.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "firmware/control/force/excitation.h"

namespace slipstack {
namespace {

/// Runs until it is over; what came out in each tick.
std::vector<float> run(Excitation& excitation, const ExcitationSettings& settings,
                       std::size_t most = 1000000) {
  excitation.begin(settings);
  std::vector<float> values;
  while (excitation.running() && values.size() < most) values.push_back(excitation.step({}, 0.0F));
  return values;
}

ExcitationSettings drawn(std::mt19937& random) {
  const auto between = [&](int low, int high) { return std::uniform_int_distribution<>(low, high)(random); };
  ExcitationSettings settings;
  settings.amplitude = static_cast<float>(between(1, 1000)) * 0.1F;
  settings.largest_deviation_m = 1e-3F;
  settings.period_ticks = static_cast<std::uint32_t>(between(400, 20000));
  settings.lowest = static_cast<std::uint32_t>(between(2, 20));
  settings.highest = settings.lowest + 2U * static_cast<std::uint32_t>(between(10, 35));
  settings.periods = static_cast<std::uint32_t>(between(3, 6));
  return settings;
}

double power_at(const std::vector<float>& values, std::size_t begin, std::size_t period, std::size_t line) {
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < period; ++i) {
    const double phase =
        -2.0 * std::numbers::pi * static_cast<double>(i * line % period) / static_cast<double>(period);
    sum += static_cast<double>(values[begin + i]) * std::polar(1.0, phase);
  }
  return 2.0 * std::norm(sum / static_cast<double>(period));
}

// The band is in whole harmonics of the period next to the frequencies asked for, from the first one on; the
// highest may be one higher, so that a period ends in the phase in which it began.
TEST(Excitation, ABandIsTheHarmonicsNextToIt) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> harmonics(0.0, 60.0);
  for (int i = 0; i < 500; ++i) {
    ExcitationSettings settings;
    settings.period_ticks = 1000;
    const double low = harmonics(random) * (i % 4 == 0 ? 0.05 : 1.0), high = low + harmonics(random);
    // A period of 0.2 s.
    settings.set_band(static_cast<float>(low / 0.2), static_cast<float>(high / 0.2), 2e-4F);
    EXPECT_NEAR(settings.lowest, std::max(1.0, low), 0.501) << low;
    EXPECT_GE(settings.highest, std::max(1.0, high) - 0.501);
    EXPECT_LE(settings.highest, std::max(1.0, high) + 1.501);
    EXPECT_EQ((settings.lowest + settings.highest) % 2, 0U);
    const bool asked_for = std::lround(std::max(1.0, high)) % 2 == std::lround(std::max(1.0, low)) % 2;
    if (asked_for && std::abs(high - std::floor(high) - 0.5) > 0.01 &&
        std::abs(low - std::floor(low) - 0.5) > 0.01) {
      EXPECT_EQ(settings.highest, static_cast<std::uint32_t>(std::lround(std::max(1.0, high))));
    }
  }
}

TEST(Excitation, PeriodsAreTheSameBitForBit) {
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    const ExcitationSettings settings = drawn(random);
    Excitation excitation;
    const std::vector<float> values = run(excitation, settings);
    const std::size_t period = settings.period_ticks;
    for (std::size_t k = 2 * period; k + period < settings.periods * period; ++k) {
      ASSERT_EQ(std::bit_cast<std::uint32_t>(values[k]),
                std::bit_cast<std::uint32_t>(values[k + settings.period_ticks]))
          << i << ' ' << k;
    }
    EXPECT_EQ(excitation.state(), ExcitationState::kComplete);
    EXPECT_EQ(excitation.periods(), settings.periods);
    // Half a period to fade out.
    EXPECT_EQ(values.size(), settings.periods * settings.period_ticks + settings.period_ticks / 2);
  }
}

// At least 95 % of the power lies between the two frequencies, each line has a share of it, and the crest
// factor is that of a sine.
TEST(Excitation, PowerLiesInTheBand) {
  std::mt19937 random(2);
  for (int i = 0; i < 20; ++i) {
    const ExcitationSettings settings = drawn(random);
    Excitation excitation;
    const std::vector<float> values = run(excitation, settings);
    const std::size_t period = settings.period_ticks;
    double all = 0.0;
    double largest = 0.0;
    for (std::size_t k = 0; k < period; ++k) {
      all += std::pow(static_cast<double>(values[period + k]), 2);
      largest = std::max(largest, std::fabs(static_cast<double>(values[period + k])));
    }
    all /= static_cast<double>(period);
    double inside = 0.0;
    const double lines = settings.highest - settings.lowest;
    for (std::size_t line = settings.lowest; line <= settings.highest; ++line) {
      const double power = power_at(values, period, period, line);
      inside += power;
      EXPECT_GT(power, 0.1 * all / lines) << line;
    }
    EXPECT_GT(inside, 0.93 * all);
    EXPECT_LE(inside, 1.001 * all);
    EXPECT_LE(largest, static_cast<double>(settings.amplitude) * 1.002);
    EXPECT_NEAR(largest / std::sqrt(all), std::numbers::sqrt2, 0.05);
  }
}

TEST(Excitation, BeginsAndEndsSoftly) {
  ExcitationSettings settings{.amplitude = 10.0F,
                              .largest_deviation_m = 1e-3F,
                              .period_ticks = 4000,
                              .lowest = 4,
                              .highest = 40,
                              .periods = 2};
  Excitation excitation;
  excitation.begin(settings);
  float last = 0.0F;
  float largest_step = 0.0F;
  for (int i = 0; i < 6000 && excitation.running(); ++i) {
    if (i == 3000) excitation.stop();
    const float value = excitation.step({}, 0.0F);
    largest_step = std::max(largest_step, std::fabs(value - last));
    last = value;
  }
  EXPECT_EQ(excitation.state(), ExcitationState::kStopped);
  EXPECT_LT(std::fabs(last), 4e-3F);  // e^-8 of the amplitude
  // The fastest that a sine of the highest frequency changes in a tick.
  const double steepest = 10.0 * 2.0 * std::numbers::pi * 40.0 / 4000.0;
  EXPECT_LT(largest_step, 1.05 * steepest);
  EXPECT_GT(largest_step, 0.6 * steepest);
}

// Whatever one before has left: nothing of it is in what a new one says of itself, nor in its values.
TEST(Excitation, BeginsAnewWithNothingOfTheOneBefore) {
  std::mt19937 random(11);
  for (int i = 0; i < 20; ++i) {
    const ExcitationSettings settings = drawn(random), before = drawn(random);
    Excitation fresh;
    fresh.begin(settings);
    Excitation again;
    again.begin(before);
    const std::uint32_t longest = before.period_ticks * before.periods;
    const auto ticks = static_cast<std::uint32_t>(1 + random() % longest);
    for (std::uint32_t tick = 0; tick < ticks; ++tick) again.step({}, 0.0F);
    again.note(0xFFFF);
    if (i % 2 == 0) again.stop();
    again.leave();
    again.begin(settings);
    EXPECT_EQ(again.value(), 0.0F);
    EXPECT_EQ(again.periods(), 0U);
    EXPECT_EQ(again.limits(), 0);
    EXPECT_TRUE(again.running());
    for (std::uint32_t tick = 0; tick < 2 * settings.period_ticks; ++tick)
      ASSERT_EQ(again.step({}, 0.0F), fresh.step({}, 0.0F)) << tick;
    EXPECT_EQ(again.periods(), fresh.periods());
  }
}

constexpr ExcitationSettings kThreePeriods{.amplitude = 1.0F,
                                           .largest_deviation_m = 1e-4F,
                                           .period_ticks = 1000,
                                           .lowest = 1,
                                           .highest = 21,
                                           .periods = 3};

TEST(Excitation, EndsWhereTheAxisLeavesItsPlaceOrAccelerates) {
  const ExcitationSettings& settings = kThreePeriods;
  Excitation excitation;
  excitation.begin(settings);
  for (int i = 0; i < 500; ++i) excitation.step({}, 0.99e-4F);
  EXPECT_TRUE(excitation.running());
  excitation.step({}, -1.01e-4F);
  EXPECT_EQ(excitation.state(), ExcitationState::kTooFar);
  excitation.begin(settings);
  excitation.step({.velocity = 3.0F}, 0.0F);
  EXPECT_TRUE(excitation.running());
  excitation.step({.velocity = 3.0F, .acceleration = 1e-3F}, 0.0F);
  EXPECT_EQ(excitation.state(), ExcitationState::kEnded);
}

// The band is that of the harmonics next to its two frequencies, the upper one by one more where their sum
// would be odd.
TEST(Excitation, TheBandIsOfTheNearestHarmonics) {
  std::mt19937 random(14);
  for (int i = 0; i < 1000; ++i) {
    ExcitationSettings settings;
    settings.period_ticks = 1000 + static_cast<std::uint32_t>(random() % 60000);
    const double period_s = settings.period_ticks * 1e-4;
    const double low_Hz = std::uniform_real_distribution<double>(1.0, 200.0)(random) / period_s;
    const double high_Hz = low_Hz + std::uniform_real_distribution<double>(2.0, 800.0)(random) / period_s;
    settings.set_band(static_cast<float>(low_Hz), static_cast<float>(high_Hz), 1e-4F);
    EXPECT_NEAR(settings.lowest, low_Hz * period_s, 0.501);
    EXPECT_EQ((settings.lowest + settings.highest) % 2, 0U);
    EXPECT_GT(settings.highest, high_Hz * period_s - 0.501);
    EXPECT_LT(settings.highest, high_Hz * period_s + 1.501);
  }
  ExcitationSettings settings;
  settings.period_ticks = 1000;
  settings.set_band(0.0F, 30.0F, 1e-4F);
  EXPECT_EQ(settings.lowest, 1U) << "at least one in a period";
}

// The tick after the one that left it is told so, once: what was excited fades then.
TEST(Excitation, SaysOnceThatItWasLeft) {
  const ExcitationSettings& settings = kThreePeriods;
  Excitation excitation;
  EXPECT_FALSE(excitation.left());
  for (int run = 0; run < 3; ++run) {
    excitation.begin(settings);
    EXPECT_TRUE(excitation.takes_part());
    for (int i = 0; i < 100; ++i) {
      excitation.step({}, 0.0F);
      EXPECT_FALSE(excitation.left());
    }
    excitation.leave();
    EXPECT_FALSE(excitation.takes_part());
    EXPECT_TRUE(excitation.left());
    EXPECT_FALSE(excitation.left());
  }
}

TEST(Excitation, RefusesWhatIsNone) {
  const ExcitationSettings& good = kThreePeriods;
  EXPECT_TRUE(good.possible());
  for (int fault = 0; fault < 6; ++fault) {
    ExcitationSettings bad = good;
    if (fault == 0) bad.amplitude = std::nanf("");
    if (fault == 1) bad.amplitude = 0.0F;
    if (fault == 2) bad.highest = 251;
    if (fault == 3) bad.lowest = 21;
    if (fault == 4) bad.periods = 0;
    if (fault == 5) bad.largest_deviation_m = 0.0F;
    EXPECT_FALSE(bad.possible()) << fault;
  }
  for (int i = 1; i < 200; ++i) {
    ExcitationSettings band = good;
    band.set_band(static_cast<float>(i), 200.0F, 1e-4F);
    EXPECT_EQ((band.lowest + band.highest) % 2, 0U);
  }
}

}  // namespace
}  // namespace slipstack
