// SPDX-License-Identifier: Apache-2.0
// What rings above the band of the rows is found; a force of the position and a motion are not that.
#include "workbench/diagnose/alternatives/ringing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/unit/estimate/estimate_support.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/row_weights.h"

namespace slipstack::workbench {
namespace {

using test::Draw;

constexpr double kRate_Hz = 2000.0;
constexpr double kRing_Hz = 311.0;

/// The log with a force of noise of 0.1 N and `more`.
Measurement with_force(Log log, const std::function<double(std::size_t)>& more, std::uint64_t seed) {
  Draw draw(seed);
  for (std::size_t i = 0; i < log.force_N.size(); ++i) log.force_N[i] = 0.1 * draw.normal() + more(i);
  Measurement measurement(std::move(log));
  weigh_rows(measurement);
  return measurement;
}

/// What is found in the residual of a mass.
std::optional<Structure> found_in(Log log, const std::function<double(std::size_t)>& more,
                                  std::uint64_t seed) {
  const Measurement measurement = with_force(std::move(log), more, seed);
  return ringing_beyond_rows(measurement, fit_effects(measurement, {"inertia"}, {}));
}

/// A force that rings with 1 % damping from some moments on, as if something struck the axis.
double rings(std::size_t sample) {
  const double time_s = static_cast<double>(sample) / kRate_Hz;
  double sum_N = 0.0;
  for (const double start_s :
       {2.1, 3.0, 5.2, 6.1, 8.8, 9.3, 11.0, 13.7, 15.1, 18.2, 21.3, 22.0, 25.9, 28.0}) {
    if (time_s < start_s) continue;
    const double phase = 2.0 * std::numbers::pi * kRing_Hz * (time_s - start_s);
    sum_N += std::exp(-0.01 * phase) * std::sin(phase);
  }
  return sum_N;
}

TEST(Ringing, IsFoundWithItsFrequencyAndSize) {
  double squares = 0.0;
  for (std::size_t i = 0; i < 60'000; ++i) squares += rings(i) * rings(i);
  const double rms_N = std::sqrt(squares / 60'000.0);
  const Measurement measurement = with_force(test::wandering_log(3, kRate_Hz, 60'000), rings, 5);
  const FittedModel mass = fit_effects(measurement, {"inertia"}, {});
  const auto found = ringing_beyond_rows(measurement, mass);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->coordinate, Coordinate::frequency);
  EXPECT_NEAR(found->where, kRing_Hz, 0.01 * kRing_Hz);
  const double error_N = mass.train_rmse_N;
  EXPECT_NEAR(found->error_reduction, 1.0 - error_N / std::hypot(error_N, rms_N), 0.05);
}

TEST(Ringing, IsNotFoundInNoise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_FALSE(found_in(
        test::wandering_log(3, kRate_Hz, 60'000), [](std::size_t) { return 0.0; }, seed))
        << seed;
  }
}

// While the speed is constant, a force of a short pitch has a peak as narrow.
TEST(Ringing, IsNoForceOfThePosition) {
  constexpr double kSpeed_mps = 0.05;
  constexpr double kMove_s = 2.0;
  constexpr double kRamp_s = 0.1;
  const auto position_m = [](double t) {
    const double in_cycle = std::fmod(t, 2.0 * kMove_s);
    const double u = in_cycle < kMove_s ? in_cycle : 2.0 * kMove_s - in_cycle;
    if (u < kRamp_s) return 0.5 * kSpeed_mps * u * u / kRamp_s;
    const double left = kMove_s - u;
    if (left < kRamp_s) return kSpeed_mps * (kMove_s - kRamp_s - 0.5 * left * left / kRamp_s);
    return kSpeed_mps * (u - 0.5 * kRamp_s);
  };
  const Log log = test::log_of(kRate_Hz, 60'000, position_m, [](double) { return 0.0; });
  const double pitch_m = kSpeed_mps / kRing_Hz;
  const auto ripple = [&](std::size_t i) {
    return std::sin(2.0 * std::numbers::pi * position_m(static_cast<double>(i) / kRate_Hz) / pitch_m);
  };
  EXPECT_FALSE(found_in(log, ripple, 5));
}

// What the encoder shows as motion of the mass is no ringing.
TEST(Ringing, IsNoMotionOfTheMass) {
  Log log = test::wandering_log(3, kRate_Hz, 60'000);
  const double turn = 2.0 * std::numbers::pi * kRing_Hz;
  for (std::size_t i = 0; i < log.position_m.size(); ++i) log.position_m[i] -= rings(i) / (turn * turn * 5.0);
  log.mass_kg = 5.0;
  EXPECT_FALSE(found_in(log, rings, 5));
}

}  // namespace
}  // namespace slipstack::workbench
