// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/motion_extremes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace slipstack::workbench {
namespace {

/// A sum of two sines, whose largest derivatives are known, read by an encoder with noise.
struct KnownMotion {
  Log log;
  MotionExtremes truth;
};

KnownMotion known_motion(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double amplitude_m = std::exp(uniform(std::log(5e-3), std::log(0.3)));
  const double rate = uniform(2.0, 8.0);
  const double step_m = std::exp(uniform(std::log(1e-8), std::log(2e-6)));
  const double mass_kg = uniform(2.0, 80.0);
  std::normal_distribution<double> position_noise(0.0, 0.3 * step_m);
  KnownMotion known;
  known.log.sample_rate_Hz = 1000.0;
  known.log.mass_kg = mass_kg;
  known.log.encoder_resolution_m = step_m;
  const double level_N = mass_kg * amplitude_m * rate * rate;
  std::normal_distribution<double> force_noise(0.0, 0.01 * level_N);
  for (int i = 0; i < 20'000; ++i) {
    const double t = 1e-3 * i;
    const double x = amplitude_m * (std::sin(rate * t) + 0.2 * std::sin(3.0 * rate * t));
    const double v = amplitude_m * rate * (std::cos(rate * t) + 0.6 * std::cos(3.0 * rate * t));
    const double a = -amplitude_m * rate * rate * (std::sin(rate * t) + 1.8 * std::sin(3.0 * rate * t));
    const double j =
        -amplitude_m * std::pow(rate, 3.0) * (std::cos(rate * t) + 5.4 * std::cos(3.0 * rate * t));
    const double force_N = mass_kg * a + 0.2 * level_N * std::tanh(v / 1e-3);
    known.truth.add({x, x, std::abs(v), std::abs(a), std::abs(j), std::abs(force_N)});
    known.log.position_m.push_back(step_m * std::round((x + position_noise(random)) / step_m));
    known.log.force_N.push_back(force_N + force_noise(random));
  }
  // A spike of one sample, as quantisation and disturbances leave in a second derivative.
  known.log.force_N[7'777] += 3.0 * level_N;
  return known;
}

TEST(MotionExtremes, AreReachedButNeverExceeded) {
  std::mt19937_64 random(20261122);
  for (int trial = 0; trial < 20; ++trial) {
    const KnownMotion known = known_motion(random);
    const Measurement measurement(known.log);
    MotionExtremes found;
    found.take(measurement, 0, measurement.sample_count());
    const MotionExtremes& truth = known.truth;
    const auto expect = [&](double value, double most, double least_share, const char* what) {
      EXPECT_LE(value, most) << what << " in trial " << trial;
      EXPECT_GE(value, least_share * most) << what << " in trial " << trial;
    };
    const double step_m = *known.log.encoder_resolution_m;
    EXPECT_GE(found.low_m, truth.low_m - 2.0 * step_m);
    EXPECT_LE(found.high_m, truth.high_m + 2.0 * step_m);
    EXPECT_GE(found.high_m - found.low_m, 0.95 * (truth.high_m - truth.low_m));
    expect(found.velocity_mps, truth.velocity_mps, 0.9, "velocity");
    expect(found.acceleration_mps2, truth.acceleration_mps2, 0.8, "acceleration");
    expect(found.jerk_mps3, truth.jerk_mps3, 0.4, "jerk");
    expect(found.force_N, truth.force_N, 0.8, "force");
  }
}

TEST(MotionExtremes, OfStandstillAreNone) {
  Log log;
  log.sample_rate_Hz = 1000.0;
  log.mass_kg = 10.0;
  log.encoder_resolution_m = 1e-6;
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  for (int i = 0; i < 20'000; ++i) {
    log.position_m.push_back(1e-6 * std::round(noise(random)));
    log.force_N.push_back(noise(random));
  }
  const Measurement measurement(log);
  MotionExtremes found;
  found.take(measurement, 0, measurement.sample_count());
  EXPECT_EQ(found.velocity_mps, 0.0);
  EXPECT_EQ(found.acceleration_mps2, 0.0);
  EXPECT_EQ(found.jerk_mps3, 0.0);
}

}  // namespace
}  // namespace slipstack::workbench
