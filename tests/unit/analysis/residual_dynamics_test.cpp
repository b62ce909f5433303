// SPDX-License-Identifier: Apache-2.0
#include "workbench/analysis/residual_dynamics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "workbench/diagnose/evidence/held_out.h"

namespace slipstack::workbench {
namespace {

using Complex = std::complex<double>;

constexpr double kRate_Hz = 1000.0;
constexpr double kMass_kg = 8.0;
constexpr double kModalMass_kg = 3.0;
constexpr double kResonance_Hz = 18.0;
constexpr double kDamping = 0.05;

/// Force over acceleration of a mass that carries another on a damped spring, from the equations of motion.
Complex apparent_mass_kg(double frequency_Hz) {
  const double w = 2.0 * std::numbers::pi * frequency_Hz;
  const double w0 = 2.0 * std::numbers::pi * kResonance_Hz;
  const Complex carried{w0 * w0, 2.0 * kDamping * w0 * w};
  return kMass_kg + kModalMass_kg * carried / (carried - w * w);
}

/// Many sines of random phase, whose accelerations are equally large from 0.5 to 45 Hz; each with the force
/// that the two masses need for it.
Log two_mass_log(double noise_N) {
  Log log;
  log.path = "test";
  log.sample_rate_Hz = kRate_Hz;
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
  std::normal_distribution<double> noise(0.0, noise_N);
  constexpr int kSamples = 60'000;
  log.position_m.assign(kSamples, 0.0);
  log.force_N.assign(kSamples, 0.0);
  constexpr int kSines = 300;
  for (int line = 0; line < kSines; ++line) {
    const double frequency_Hz = 0.5 + 44.5 * (line + 0.37) / kSines;
    const double w = 2.0 * std::numbers::pi * frequency_Hz;
    const double start = phase(random);
    const Complex force = 0.2 * apparent_mass_kg(frequency_Hz);
    for (std::size_t i = 0; i < kSamples; ++i) {
      const Complex turn = std::polar(1.0, w * static_cast<double>(i) / kRate_Hz + start);
      log.position_m[i] -= 0.2 / (w * w) * turn.real();
      log.force_N[i] += (force * turn).real();
    }
  }
  for (double& force_N : log.force_N) force_N += noise(random);
  return log;
}

Measurement two_masses(double noise_N) {
  ConditioningOptions options;
  options.bandwidth_Hz = 50.0;
  return Measurement(two_mass_log(noise_N), options);
}

TEST(AxisResponse, IsThatOfTheTwoMasses) {
  const Measurement measurement = two_masses(0.1);
  const AxisResponse found = axis_response(measurement, measurement.force_N());
  ASSERT_GT(found.frequency_Hz.size(), 50U);
  double worst = 0.0;
  int judged = 0;
  for (std::size_t i = 0; i < found.frequency_Hz.size(); ++i) {
    const double f = found.frequency_Hz[i];
    // Within the excitation, and where the response is nearly constant over the width of a segment's line.
    if (f < 2.0 || f > 44.0 || std::abs(f - kResonance_Hz) < 5.0) continue;
    const Complex should = 1.0 / apparent_mass_kg(f);
    worst = std::max(worst, std::abs(found.per_kg[i] / should - 1.0));
    ++judged;
  }
  EXPECT_GT(judged, 40);
  EXPECT_LT(worst, 0.03);
  // The carried mass moves along below its resonance, and no longer above it.
  const auto at = [&](double f) {
    const auto next = std::lower_bound(found.frequency_Hz.begin(), found.frequency_Hz.end(), f);
    return std::abs(found.per_kg[static_cast<std::size_t>(next - found.frequency_Hz.begin())]);
  };
  EXPECT_NEAR(at(3.0) * (kMass_kg + kModalMass_kg), 1.0, 0.06);
  EXPECT_LT(at(kResonance_Hz), 0.5 / (kMass_kg + kModalMass_kg));
  EXPECT_GT(at(22.0), 1.3 / (kMass_kg + kModalMass_kg));
}

TEST(MotionCoherence, IsOneOfWhatFollowsTheMotionAndByChanceOfWhatDoesNot) {
  const Measurement measurement = two_masses(0.1);
  const Eigen::VectorXd velocity = measurement.filtered(measurement.velocity_mps());
  const MotionCoherence follows = motion_coherence(measurement, 30.0 * velocity);
  ASSERT_FALSE(follows.frequency_Hz.empty());
  EXPECT_LE(follows.frequency_Hz.back(), measurement.bandwidth_Hz());
  for (std::size_t i = 0; i < follows.frequency_Hz.size(); ++i) {
    if (follows.frequency_Hz[i] > 2.0 && follows.frequency_Hz[i] < 44.0) {
      EXPECT_GT(follows.coherence[i], 0.97);
    }
  }
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal(0.0, 1.0);
  int above = 0;
  int all = 0;
  for (int round = 0; round < 20; ++round) {
    Eigen::VectorXd noise(velocity.size());
    for (double& value : noise) value = normal(random);
    const MotionCoherence none = motion_coherence(measurement, noise);
    for (std::size_t i = 0; i < none.frequency_Hz.size(); ++i) {
      if (none.frequency_Hz[i] < 2.0 || none.frequency_Hz[i] > 44.0) continue;
      above += none.coherence[i] > none.chance;
      ++all;
    }
  }
  EXPECT_GT(above, 0.03 * all);
  EXPECT_LT(above, 0.08 * all);
}

TEST(Autocorrelation, OfASineIsACosineAndOfFilteredNoiseThatOfTheFilter) {
  const Measurement measurement = two_masses(0.1);
  const Eigen::VectorXd time_s = row_times(measurement);
  const double w = 2.0 * std::numbers::pi * 3.0;
  const Autocorrelation sine = autocorrelation(measurement, (w * time_s.array()).sin().matrix());
  ASSERT_GT(sine.lag_s.size(), 50U);
  EXPECT_LE(sine.lag_s.back(), 1.0 + 1e-9);
  for (std::size_t i = 0; i < sine.lag_s.size(); ++i) {
    EXPECT_NEAR(sine.correlation[i], std::cos(w * sine.lag_s[i]), 0.03) << sine.lag_s[i];
  }
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<double> noise(measurement.sample_count());
  for (double& value : noise) value = normal(random);
  const Autocorrelation white = autocorrelation(measurement, measurement.filtered(noise));
  EXPECT_EQ(white.white[0], 1.0);
  double worst = 0.0;
  for (std::size_t i = 0; i < white.lag_s.size(); ++i) {
    worst = std::max(worst, std::abs(white.correlation[i] - white.white[i]));
  }
  // Standard deviation of each: about one over the root of the independent rows.
  const double deviation = 1.0 / std::sqrt(2.0 * measurement.bandwidth_Hz() * measurement.duration_s());
  EXPECT_LT(worst, 5.0 * deviation);
  EXPECT_GT(worst, 0.5 * deviation);
}

TEST(ResidualDynamics, LeavesOutWhatTheLogDoesNotSupport) {
  const Measurement measurement = two_masses(0.1);
  const ForceRows rows{measurement.force_N(),
                       kMass_kg * measurement.filtered(measurement.acceleration_mps2())};
  nlohmann::json data;
  add_residual_dynamics(data, measurement, rows, &rows);
  EXPECT_EQ(data["coherence"]["after"], data["coherence"]["residual"]);
  EXPECT_EQ(data["response"]["model"]["gain"].size(), data["response"]["frequency_Hz"].size());
  // Beyond the excitation nothing is drawn.
  int beyond = 0;
  for (std::size_t i = 0; i < data["response"]["frequency_Hz"].size(); ++i) {
    if (data["response"]["frequency_Hz"][i] > 47.0) {
      ++beyond;
      EXPECT_TRUE(data["response"]["measured"]["gain"][i].is_null());
    }
  }
  EXPECT_GT(beyond, 2);

  Log still = two_mass_log(1.0);
  still.position_m.resize(100);
  still.force_N.resize(100);
  nlohmann::json nothing;
  const Measurement brief(still);
  const ForceRows none{brief.force_N(), brief.force_N()};
  add_residual_dynamics(nothing, brief, none, nullptr);
  EXPECT_FALSE(nothing.contains("coherence"));
  EXPECT_FALSE(nothing.contains("autocorrelation"));
}

}  // namespace
}  // namespace slipstack::workbench
