// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/sampling/sampling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/log/log_support.h"

namespace slipstack::workbench::test {
namespace {

const WhereRow kWhere = [](std::size_t row) { return "row " + std::to_string(row); };

// Uniform time stamps written with `digits` decimals, as a logger prints them.
std::vector<double> rounded_stamps(double rate_Hz, double start_s, std::size_t count, int digits) {
  const double scale = std::pow(10.0, digits);
  std::vector<double> stamps(count);
  for (std::size_t i = 0; i < count; ++i) {
    stamps[i] = std::round((start_s + static_cast<double>(i) / rate_Hz) * scale) / scale;
  }
  return stamps;
}

std::string refused_sampling(const std::vector<double>& stamps) {
  try {
    require_growing_time(stamps, kWhere);
    uniform_sampling(stamps, 0.0, kWhere);
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

// For any rate and rounding with increasing stamps, the rate is found as accurately as the stamps allow.
TEST(Sampling, FindsTheRateOfRoundedStamps) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> log_rate(std::log(10.0), std::log(50e3));
  std::uniform_real_distribution<double> start(-100.0, 1000.0);
  std::uniform_int_distribution<std::size_t> counts(100, 20'000);
  for (int round = 0; round < 500; ++round) {
    const double rate_Hz = std::exp(log_rate(random));
    const std::size_t count = counts(random);
    // A step is at least 2.5 units of the last digit.
    const int digits = static_cast<int>(std::ceil(std::log10(2.5 * rate_Hz)));
    const double unit_s = std::pow(10.0, -digits);
    const std::vector<double> stamps = rounded_stamps(rate_Hz, start(random), count, digits);
    const Sampling sampling = uniform_sampling(stamps, 0.0, kWhere);
    const double length_s = stamps.back() - stamps.front();
    EXPECT_NEAR(sampling.rate_Hz / rate_Hz, 1.0, 2.0 * unit_s / length_s)
        << rate_Hz << " Hz, " << digits << " digits";
    EXPECT_EQ(sampling.start_s, stamps.front());
  }
}

TEST(Sampling, GivesWholeRatesExactly) {
  for (const double rate_Hz : {1.0, 200.0, 1000.0, 2000.0, 8000.0, 10'000.0, 3000.0, 44'100.0}) {
    for (const std::size_t count : {std::size_t{500}, std::size_t{100'000}}) {
      EXPECT_EQ(uniform_sampling(rounded_stamps(rate_Hz, 12.004, count, 6), 0.0, kWhere).rate_Hz, rate_Hz);
    }
  }
}

TEST(Sampling, GivesWholeNanosecondsExactly) {
  const double rate_Hz = 1e9 / 62'500.0;  // 62.5 µs
  EXPECT_EQ(uniform_sampling(rounded_stamps(rate_Hz, 0.0, 5000, 7), 0.0, kWhere).rate_Hz, rate_Hz);
  const double slow_Hz = 1e9 / 3e6;  // 3 ms
  EXPECT_EQ(uniform_sampling(rounded_stamps(slow_Hz, 0.0, 5000, 3), 0.0, kWhere).rate_Hz, slow_Hz);
}

// A rate is not rounded to a whole number that the stamps exclude.
TEST(Sampling, KeepsAnOddRate) {
  const Sampling sampling = uniform_sampling(rounded_stamps(1000.05, 0.0, 100'000, 6), 0.0, kWhere);
  EXPECT_NEAR(sampling.rate_Hz, 1000.05, 1e-5);
}

// Just below and just above the tolerance of 1 %.
TEST(Sampling, ToleratesOnePercentOfAStep) {
  std::vector<double> stamps = rounded_stamps(1000.0, 0.0, 1000, 12);
  stamps[500] += 0.9e-5;
  EXPECT_EQ(refused_sampling(stamps), "");
  stamps[500] += 0.2e-5 + 1.23456789e-10;
  EXPECT_NE(refused_sampling(stamps).find("row 500: column time_s: "), std::string::npos)
      << refused_sampling(stamps);
}

TEST(Sampling, NamesTheGapWhereverItIs) {
  std::mt19937_64 random(2);
  std::uniform_int_distribution<std::size_t> where(1, 998);
  std::uniform_int_distribution<std::size_t> lengths(1, 5000);
  for (const int digits : {3, 4, 6, 9}) {
    for (int round = 0; round < 50; ++round) {
      const std::size_t row = where(random);
      std::vector<double> stamps = rounded_stamps(1000.0, 3.0, 7000, digits);
      const auto first = stamps.begin() + static_cast<std::ptrdiff_t>(row);
      stamps.erase(first, first + static_cast<std::ptrdiff_t>(lengths(random)));
      const std::string message = refused_sampling(stamps);
      EXPECT_TRUE(message.starts_with("row " + std::to_string(row) + ": column time_s: a gap of")) << message;
    }
  }
}

TEST(Sampling, NamesTheFirstOfManyGaps) {
  std::vector<double> stamps;
  for (std::size_t i = 0; i < 2000; ++i) {
    if (i % 10 != 9) stamps.push_back(static_cast<double>(i) * 1e-3);
  }
  EXPECT_TRUE(refused_sampling(stamps).starts_with("row 9: column time_s: a gap of 0.002 s"))
      << refused_sampling(stamps);
}

TEST(Sampling, RefusesAClockThatDrifts) {
  std::vector<double> stamps(10'000);
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const double t = static_cast<double>(i) * 1e-3;
    stamps[i] = t + 1e-3 * t * t / 10.0;
  }
  EXPECT_NE(refused_sampling(stamps).find("off the uniform time"), std::string::npos);
}

TEST(Sampling, RefusesAChangedRate) {
  std::vector<double> stamps(2000);
  for (std::size_t i = 1; i < stamps.size(); ++i) stamps[i] = stamps[i - 1] + (i < 1000 ? 1e-3 : 1.1e-3);
  EXPECT_NE(refused_sampling(stamps).find("off the uniform time"), std::string::npos);
}

TEST(Sampling, RefusesAStampTooEarly) {
  std::vector<double> stamps = rounded_stamps(1000.0, 0.0, 1000, 6);
  stamps[400] -= 0.0007;
  EXPECT_TRUE(refused_sampling(stamps).starts_with("row 400: column time_s: a step of 0.0003 s"))
      << refused_sampling(stamps);
}

TEST(Sampling, AllowsForSinglePrecision) {
  std::vector<double> stamps = rounded_stamps(4000.0, 200.0, 50'000, 9);
  for (double& stamp : stamps) stamp = static_cast<double>(static_cast<float>(stamp));
  EXPECT_NE(refused_sampling(stamps), "");
  EXPECT_EQ(uniform_sampling(stamps, 0x1p-23 * stamps.back(), kWhere).rate_Hz, 4000.0);
}

std::string irregular_log(std::size_t count, const std::function<double(std::size_t)>& time_s,
                          const char* header) {
  std::string text = std::string(header) + "time_s,position_m,force_N\n";
  for (std::size_t i = 0; i < count; ++i) {
    const double t = time_s(i);
    char line[128];
    std::snprintf(line, sizeof line, "%.9f,%.12f,%.9f\n", t, 1e-3 * t, 2.0 - 3.0 * t);
    text += line;
  }
  return text;
}

// Linear interpolation reproduces linear signals exactly.
TEST(Resampling, IsExactForLinearSignals) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> jitter(-0.4, 0.4);
  std::vector<double> times(1000);
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = (static_cast<double>(i) + jitter(random)) * 1e-3;
  const auto time_s = [&](std::size_t i) { return times[i]; };
  const std::string text = irregular_log(times.size(), time_s, "# sampling: irregular\n");
  const Log log = parse_text(text);
  EXPECT_EQ(violated_guarantee(log), "");
  EXPECT_NEAR(log.sample_rate_Hz, 1000.0, 30.0);
  const double length_s = times.back() - times.front();
  EXPECT_NEAR(static_cast<double>(log.position_m.size()), length_s * log.sample_rate_Hz, 1.5);
  for (std::size_t i = 0; i < log.position_m.size(); ++i) {
    const double t = log.start_time_s + static_cast<double>(i) / log.sample_rate_Hz;
    ASSERT_NEAR(log.position_m[i], 1e-3 * t, 2e-12);
    ASSERT_NEAR(log.force_N[i], 2.0 - 3.0 * t, 1e-8);
  }
  EXPECT_TRUE(has_note(log, "irregular sampling: 1000 samples interpolated"));
  // The same log without the header line is refused.
  EXPECT_NE(refusal(irregular_log(times.size(), time_s, "")), "");
}

TEST(Resampling, LeavesUniformSamplesWhereTheyAre) {
  const Log plain = parse_text(usual_log());
  const Log same = parse_text("# sampling: irregular\n" + usual_log());
  ASSERT_EQ(same.position_m.size(), plain.position_m.size());
  EXPECT_NEAR(same.sample_rate_Hz, 1000.0, 1e-6);
  for (std::size_t i = 0; i < plain.force_N.size(); ++i) EXPECT_NEAR(same.force_N[i], plain.force_N[i], 1e-7);
}

// A stage that oscillates with 0.1 m at 2 Hz, read by an encoder of 1 um at 2 kHz.
double swing_m(double t) {
  return 1e-6 * std::round(1e5 * std::sin(4.0 * std::numbers::pi * t));
}

// `taken_s`: when a sample was taken; `stamp_s`: when the log says it was.
std::string swing_log(const std::vector<double>& taken_s, const std::vector<double>& stamp_s) {
  std::string text = "# sampling: irregular\n# encoder_resolution_m: 1e-6\ntime_s,position_m,force_N\n";
  for (std::size_t i = 0; i < taken_s.size(); ++i) {
    char line[128];
    std::snprintf(line, sizeof line, "%.7f,%.6f,%.5f\n", stamp_s[i], swing_m(taken_s[i]),
                  std::cos(40.0 * taken_s[i]));
    text += line;
  }
  return text;
}

std::vector<double> even_times(std::size_t count) {
  std::vector<double> times(count);
  for (std::size_t i = 0; i < count; ++i) times[i] = static_cast<double>(i) / 2000.0;
  return times;
}

std::vector<double> with_jitter(std::vector<double> times, double share) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> jitter(-share / 2000.0, share / 2000.0);
  for (double& t : times) t += jitter(random);
  return times;
}

// The samples were taken by a clock and stamped late by a computer: they are read as uniform.
TEST(Resampling, UniformSamplesWithJitteringStampsAreReadAsUniform) {
  const std::vector<double> taken_s = even_times(4000);
  for (const double share : {0.05, 0.2}) {
    const Log log = parse_text(swing_log(taken_s, with_jitter(taken_s, share)));
    ASSERT_EQ(log.position_m.size(), taken_s.size());
    EXPECT_NEAR(log.sample_rate_Hz, 2000.0, 1e-3);
    EXPECT_TRUE(has_note(log, "taken evenly"));
    for (std::size_t i = 0; i < taken_s.size(); ++i) {
      ASSERT_NEAR(log.position_m[i], swing_m(taken_s[i]), 1e-9) << i;
      ASSERT_NEAR(log.force_N[i], std::cos(40.0 * taken_s[i]), 1e-5) << i;
    }
  }
}

TEST(Resampling, LostSamplesAmongJitteringStampsAreInterpolated) {
  const std::vector<double> all_s = even_times(4000);
  const std::vector<double> all_stamps = with_jitter(all_s, 0.2);
  std::vector<double> taken_s, stamp_s;
  for (std::size_t i = 0; i < all_s.size(); ++i) {
    if (i % 97 == 50) continue;
    taken_s.push_back(all_s[i]);
    stamp_s.push_back(all_stamps[i]);
  }
  const Log log = parse_text(swing_log(taken_s, stamp_s));
  ASSERT_EQ(log.position_m.size(), all_s.size());
  EXPECT_TRUE(has_note(log, "41 missing samples"));
  for (std::size_t i = 0; i < all_s.size(); ++i)
    ASSERT_NEAR(log.position_m[i], swing_m(all_s[i]), 1.1e-6) << i;
}

// The motion of samples that were taken at uneven times agrees with their stamps.
TEST(Resampling, UnevenStampsThatTheMotionSupportsAreUsed) {
  const std::vector<double> taken_s = with_jitter(even_times(4000), 0.2);
  const Log log = parse_text(swing_log(taken_s, taken_s));
  EXPECT_FALSE(has_note(log, "taken evenly"));
  EXPECT_TRUE(has_note(log, "samples interpolated"));
  for (std::size_t i = 0; i < log.position_m.size(); ++i) {
    const double t = log.start_time_s + static_cast<double>(i) / log.sample_rate_Hz;
    ASSERT_NEAR(log.position_m[i], swing_m(t), 1.6e-6) << i;
  }
}

// At 16 m/s^2 and 200 samples a second a straight line between neighbours has an error of 50 um.
TEST(Resampling, PositionsAreInterpolatedByCubics) {
  std::vector<double> taken_s;
  for (std::size_t i = 0; i < 400; ++i) {
    if (i % 37 != 20) taken_s.push_back(static_cast<double>(i) / 200.0);
  }
  const Log log = parse_text(swing_log(taken_s, taken_s));
  ASSERT_EQ(log.position_m.size(), 400U);
  for (std::size_t i = 0; i < 400; ++i) {
    ASSERT_NEAR(log.position_m[i], swing_m(static_cast<double>(i) / 200.0), 5e-6) << i;
  }
}

TEST(Resampling, RefusesToInterpolateALongGap) {
  const auto time_s = [](std::size_t i) { return static_cast<double>(i < 100 ? i : i + 20) * 1e-3; };
  const std::string message = refusal(irregular_log(200, time_s, "# sampling: irregular\n"));
  EXPECT_TRUE(message.starts_with("log.csv:103: column time_s: a gap of 0.021 s is too long to interpolate"))
      << message;
}

TEST(Resampling, StillRefusesTimeThatGoesBack) {
  const auto time_s = [](std::size_t i) { return static_cast<double>(i == 50 ? 40 : i) * 1e-3; };
  const std::string message = refusal(irregular_log(200, time_s, "# sampling: irregular\n"));
  EXPECT_TRUE(message.starts_with("log.csv:53: column time_s: 0.04 goes back after 0.049")) << message;
}

}  // namespace
}  // namespace slipstack::workbench::test
