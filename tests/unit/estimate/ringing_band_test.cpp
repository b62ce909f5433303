// SPDX-License-Identifier: Apache-2.0
// The bandwidth holds what rings above it, where that is more than what is left within it.
#include "workbench/estimate/nonlinear/ringing_band.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/estimate/uncertainty/row_weights.h"

namespace slipstack::workbench {
namespace {

constexpr double kRate_Hz = 1000.0;
constexpr double kRing_Hz = 83.0;
constexpr std::size_t kSamples = 30'000;

/// A force of 1 N that rings with 1 % damping from some moments on.
double rings_N(double frequency_Hz, double time_s) {
  double sum_N = 0.0;
  for (const double start_s :
       {2.1, 3.0, 5.2, 6.1, 8.8, 9.3, 11.0, 13.7, 15.1, 18.2, 21.3, 22.0, 25.9, 28.0}) {
    if (time_s < start_s) continue;
    const double phase = 2.0 * std::numbers::pi * frequency_Hz * (time_s - start_s);
    sum_N += std::exp(-0.01 * phase) * std::sin(phase);
  }
  return sum_N;
}

struct Forces {
  double ring_N = 0.0;         ///< at kRing_Hz
  double second_ring_N = 0.0;  ///< at other frequencies above the bandwidth
  double third_ring_N = 0.0;
  double step_N = 0.0;  ///< once, within the bandwidth: no model has it
  double mass_kg = 0.0;
  double encoder_m = 0.0;
};

/// With 0.05 N of white noise.
std::optional<double> bandwidth_Hz(const Forces& forces, std::uint64_t seed = 5) {
  Log log = test::wandering_log(3, kRate_Hz, kSamples);
  log.mass_kg = forces.mass_kg;
  if (forces.encoder_m > 0.0) log.encoder_resolution_m = forces.encoder_m;
  test::Draw draw(seed);
  for (std::size_t i = 0; i < log.force_N.size(); ++i) {
    const double time_s = static_cast<double>(i) / kRate_Hz;
    log.force_N[i] = 0.05 * draw.normal() + forces.ring_N * rings_N(kRing_Hz, time_s) +
                     forces.second_ring_N * rings_N(125.0, time_s) +
                     forces.third_ring_N * rings_N(61.0, time_s) +
                     forces.step_N * std::tanh(20.0 * (time_s - 15.0));
  }
  Measurement measurement(std::move(log));
  weigh_rows(measurement);
  return bandwidth_of_ringing_Hz(measurement);
}

TEST(BandwidthOfRinging, IsOneAndAHalfTimesItsFrequency) {
  const auto found_Hz = bandwidth_Hz({.ring_N = 1.0});
  ASSERT_TRUE(found_Hz.has_value());
  EXPECT_NEAR(*found_Hz, 1.5 * kRing_Hz, 0.03 * 1.5 * kRing_Hz);
}

TEST(BandwidthOfRinging, IsNoneInNoise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) EXPECT_FALSE(bandwidth_Hz({}, seed)) << seed;
}

// The rms of the rings is 0.3 N.
TEST(BandwidthOfRinging, IsNoneWhereMoreIsLeftWithinTheBand) {
  EXPECT_TRUE(bandwidth_Hz({.ring_N = 1.0, .step_N = 0.1}));
  EXPECT_FALSE(bandwidth_Hz({.ring_N = 1.0, .step_N = 1.0}));
}

TEST(BandwidthOfRinging, IsNoneWhereMostIsElsewhereAboveTheBand) {
  EXPECT_TRUE(bandwidth_Hz({.ring_N = 1.0, .second_ring_N = 0.5}));
  // Several that are no more than half each.
  EXPECT_FALSE(bandwidth_Hz({.ring_N = 1.0, .second_ring_N = 1.2, .third_ring_N = 1.1}));
}

// At 125 Hz the steps of the encoder, 0.5 um, make 0.02 N of 0.5 kg, and 4 N of 100 kg.
TEST(BandwidthOfRinging, IsNoneWhereTheEncodersStepsWouldHideIt) {
  EXPECT_TRUE(bandwidth_Hz({.ring_N = 1.0, .mass_kg = 0.5, .encoder_m = 0.5e-6}));
  EXPECT_FALSE(bandwidth_Hz({.ring_N = 1.0, .mass_kg = 100.0, .encoder_m = 0.5e-6}));
}

}  // namespace
}  // namespace slipstack::workbench
