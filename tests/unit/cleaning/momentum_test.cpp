// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/momentum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "workbench/cleaning/repair.h"

// A pulse of the force that moves the axis is none of the sensor.
namespace slipstack::workbench {
namespace {

constexpr double kSampling_Hz = 1000.0;
constexpr double kMass_kg = 6.0;
constexpr double kEncoder_m = 1e-7;

/// A mass whose speed varies as a sine, and steps by 30 mm/s up or down every 400 samples: there the force
/// has a pulse of `width` samples. `false_at`: samples of a force of 150 N that moves nothing.
struct Pulsed {
  Log log;
  std::vector<Interval> true_pulses;
  std::vector<Interval> false_pulses;
};
Pulsed pulsed(std::size_t width, std::uint64_t seed) {
  Pulsed made;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise_N(0.0, 0.05);
  double step_mps = 0.0;
  double x = 0.0;
  for (std::size_t i = 0; i < 12'000; ++i) {
    const std::size_t within = i % 400;
    double pulse_mps2 = 0.0;
    if (within >= 200 && within < 200 + width) {
      if (within == 200) made.true_pulses.push_back({i, i + width});
      pulse_mps2 = (i / 400 % 2 == 0 ? 0.03 : -0.03) * kSampling_Hz / static_cast<double>(width);
    }
    const double t_s = static_cast<double>(i) / kSampling_Hz;
    step_mps += pulse_mps2 / kSampling_Hz;
    const double velocity_mps = step_mps + 0.05 * std::sin(3.0 * t_s);
    x += velocity_mps / kSampling_Hz;
    const double acceleration_mps2 = pulse_mps2 + 0.15 * std::cos(3.0 * t_s);
    double force_N = kMass_kg * acceleration_mps2 + std::copysign(2.0, velocity_mps) + noise_N(random);
    if (i % 1700 == 850) {
      made.false_pulses.push_back({i, i + 1});
      force_N += 150.0;
    }
    made.log.position_m.push_back(kEncoder_m * std::round(x / kEncoder_m));
    made.log.force_N.push_back(force_N);
  }
  made.log.sample_rate_Hz = kSampling_Hz;
  made.log.encoder_resolution_m = kEncoder_m;
  return made;
}

class TruePulses : public testing::TestWithParam<std::size_t> {};

TEST_P(TruePulses, AreNoFaultsOfTheSensor) {
  for (const bool declared : {true, false}) {
    Pulsed made = pulsed(GetParam(), 3);
    if (declared) made.log.mass_kg = kMass_kg;
    std::vector<Interval> all = made.true_pulses;
    all.insert(all.end(), made.false_pulses.begin(), made.false_pulses.end());
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    const std::vector<Interval> faults = without_true_pulses(made.log, all);
    ASSERT_EQ(faults.size(), made.false_pulses.size()) << "mass declared: " << declared;
    for (std::size_t i = 0; i < faults.size(); ++i) EXPECT_EQ(faults[i].first, made.false_pulses[i].first);
  }
}

TEST_P(TruePulses, StayInARepairedLog) {
  Pulsed made = pulsed(GetParam(), 4);
  const std::vector<double> before_N = made.log.force_N;
  repair(made.log);
  for (const Interval& pulse : made.true_pulses)
    EXPECT_EQ(made.log.force_N[pulse.first], before_N[pulse.first]);
  for (const Interval& pulse : made.false_pulses)
    EXPECT_LT(std::abs(made.log.force_N[pulse.first]), 20.0) << pulse.first;
}

INSTANTIATE_TEST_SUITE_P(OfSamples, TruePulses, testing::Values(1, 2, 3));

}  // namespace
}  // namespace slipstack::workbench
