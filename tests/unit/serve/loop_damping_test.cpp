// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/views/loop_damping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "workbench/papers/analysis/loop_figures.h"

namespace slipstack::workbench {
namespace {

constexpr double kSineRate_Hz = 1000.0;
constexpr RationalCurve kCurve{20.0, 10e-6};

/// Slow sines of these amplitudes, twelve periods of half a second each, with the Masing loops of the curve.
Log sines(const std::vector<double>& amplitudes_m) {
  Log log;
  log.path = "test";
  log.sample_rate_Hz = kSineRate_Hz;
  log.encoder_resolution_m = 1e-9;
  constexpr int kPeriod = 500;
  for (const double amplitude_m : amplitudes_m) {
    const double tip_N = kCurve.force_N(amplitude_m);
    for (int i = 0; i < 12 * kPeriod; ++i) {
      const double phase = 2.0 * std::numbers::pi * i / kPeriod;
      const double x_m = -amplitude_m * std::cos(phase);
      const bool rises = i % kPeriod < kPeriod / 2;
      log.position_m.push_back(x_m);
      log.force_N.push_back(rises ? -tip_N + 2.0 * kCurve.force_N(0.5 * (x_m + amplitude_m))
                                  : tip_N - 2.0 * kCurve.force_N(0.5 * (amplitude_m - x_m)));
    }
  }
  return log;
}

TEST(LoopDamping, IsThatOfTheVirginCurve) {
  const std::vector<double> amplitudes_m{5e-6, 10e-6, 20e-6, 50e-6};
  ConditioningOptions options;
  options.bandwidth_Hz = 60.0;
  const Measurement measurement(sines(amplitudes_m), options);
  const Eigen::VectorXd force_N = measurement.force_N();
  const std::vector<LoopDamping> found = loop_damping(measurement, {force_N, 2.0 * force_N});
  // The steps from one amplitude to the next may close loops of their own; each of the four is there.
  for (const double amplitude_m : amplitudes_m) {
    const auto here = std::find_if(found.begin(), found.end(), [&](const LoopDamping& one) {
      return std::abs(one.amplitude_m / amplitude_m - 1.0) < 0.02;
    });
    ASSERT_NE(here, found.end()) << amplitude_m;
    EXPECT_GE(here->loops, 15U) << amplitude_m;
    const double expected = kCurve.closed_form(amplitude_m).damping_ratio;
    EXPECT_NEAR(here->ratio[0] / expected, 1.0, 0.03) << amplitude_m;
    EXPECT_NEAR(here->ratio[1], here->ratio[0], 1e-9) << "it has no unit of force";
    EXPECT_LT(here->deviation[0], 0.05 * expected) << amplitude_m;
  }
}

TEST(LoopDamping, LeavesOutWhatReleasesEnergyAndWhatDoesNotClose) {
  const Measurement measurement(sines({20e-6}), {});
  EXPECT_TRUE(loop_damping(measurement, {-measurement.force_N()}).empty());
  Log ramp = sines({20e-6});
  for (std::size_t i = 0; i < ramp.position_m.size(); ++i)
    ramp.position_m[i] += 2e-8 * static_cast<double>(i);
  const Measurement drifting(std::move(ramp), {});
  EXPECT_TRUE(loop_damping(drifting, {drifting.force_N()}).empty());
}

TEST(LoopDamping, OfAModelBesideTheMeasurement) {
  const Measurement measurement(sines({20e-6}), {});
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(measurement.force_N().size());
  const ForceRows same{measurement.force_N(), measurement.force_N()};
  nlohmann::json data;
  add_loop_damping(data, measurement, none, same, nullptr);
  ASSERT_TRUE(data.contains("damping"));
  EXPECT_EQ(data["damping"]["measured"], data["damping"]["model"]);
  EXPECT_FALSE(data["damping"].contains("after"));
}

}  // namespace
}  // namespace slipstack::workbench
