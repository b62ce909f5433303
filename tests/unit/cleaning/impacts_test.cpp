// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/impacts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "workbench/cleaning/repair.h"

// Pulses of the force that follow its changes of sign are of the drive, others of the sensor.
namespace slipstack::workbench {
namespace {

constexpr double kImpactRate_Hz = 1000.0;
constexpr std::size_t kSamples = 20'000;

/// Sines of 0.5 and 1.3 Hz of position and force, and pulses of two samples and 20 N: after each upward
/// change of the force's sign, or at random instants.
Log pulsed(bool at_reversals, std::uint64_t seed, std::vector<Interval>& pulses) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise_N(0.0, 0.05);
  std::uniform_int_distribution<std::size_t> instant(100, kSamples - 100);
  Log log;
  log.sample_rate_Hz = kImpactRate_Hz;
  log.encoder_resolution_m = 1e-7;
  std::vector<std::size_t> at;
  double last_N = 0.0;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double t_s = static_cast<double>(i) / kImpactRate_Hz;
    const double force_N = 5.0 * std::sin(3.14 * t_s) + 3.0 * std::sin(8.17 * t_s + 1.0);
    if (last_N < 0.0 && force_N >= 0.0) at.push_back(i + 15);
    last_N = force_N;
    log.force_N.push_back(force_N + noise_N(random));
    log.position_m.push_back(1e-7 * std::round(1e7 * 0.05 * std::sin(3.14 * t_s)));
  }
  if (!at_reversals) std::generate(at.begin(), at.end(), [&] { return instant(random); });
  std::sort(at.begin(), at.end());
  for (const std::size_t first : at) {
    if (first + 2 > kSamples || (!pulses.empty() && first < pulses.back().end + 10)) continue;
    pulses.push_back({first, first + 2});
    log.force_N[first] += 20.0;
    log.force_N[first + 1] += 20.0;
  }
  return log;
}

TEST(Impacts, FollowChangesOfTheSign) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<Interval> impacts;
    const Log with_play = pulsed(true, seed, impacts);
    ASSERT_GT(impacts.size(), 8u);
    EXPECT_TRUE(are_impacts(with_play, impacts)) << seed;
    impacts.resize(4);
    EXPECT_FALSE(are_impacts(with_play, impacts)) << "too few to tell";
    std::vector<Interval> disturbances;
    const Log disturbed = pulsed(false, seed, disturbances);
    EXPECT_FALSE(are_impacts(disturbed, disturbances)) << seed;
  }
}

TEST(Impacts, AreKeptAndReported) {
  std::vector<Interval> impacts;
  Log log = pulsed(true, 3, impacts);
  const std::vector<double> before_N = log.force_N;
  const Repairs repairs = repair(log);
  EXPECT_EQ(repairs.impacts.size(), impacts.size());
  EXPECT_EQ(log.force_N, before_N);
  std::vector<Interval> disturbances;
  Log disturbed = pulsed(false, 3, disturbances);
  const double peak_N = disturbed.force_N[disturbances.front().first];
  const Repairs repaired = repair(disturbed);
  EXPECT_TRUE(repaired.impacts.empty());
  EXPECT_LT(disturbed.force_N[disturbances.front().first], peak_N - 10.0);
}

}  // namespace
}  // namespace slipstack::workbench
