// SPDX-License-Identifier: Apache-2.0
// The noise floor against the residual of the true model of a simulated axis.
#include "workbench/estimate/uncertainty/row_weights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "sim_host/log/closed_loop.h"
#include "tests/unit/estimate/estimate_support.h"
#include "tests/unit/estimate/simulated_axis.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// An axis whose bank of elements the workbench can hold.
sim::Bench bench_of(sim::Setup setup, std::uint64_t seed) {
  sim::Bench bench = sim::draw_bench(setup, seed);
  bench.axis.elements = 30;
  bench.programme.seconds = 30.0;
  return bench;
}

/// Ratio of the true model's residual to the noise floor, with noise and encoder resolution multiplied by
/// these.
double left_over_floor(sim::Bench bench, std::uint64_t seed, double noise, double encoder) {
  bench.axis.force_noise_N *= noise;
  bench.axis.encoder_resolution_m *= encoder;
  Measurement measurement(test::simulate(bench, seed));
  weigh_rows(measurement);
  const Terms truth = test::truth_of(measurement, bench.axis);
  const double left_N = measurement.weighted_rms(Linearisation(measurement, truth).residual_N());
  return left_N / measurement.noise_floor_N();
}

struct Spread {
  double mean = 0.0;
  double lowest = 1e9;
  double highest = 0.0;
  double near = 0.0;  ///< share within 15 % of the floor
};
Spread spread_over(std::uint64_t first_seed, int logs, double noise, double encoder) {
  Spread spread;
  for (int k = 0; k < logs; ++k) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(k);
    const auto setup = k % 4 == 0 ? sim::Setup::kPickAndPlace : sim::Setup::kRandom;
    const double ratio = left_over_floor(bench_of(setup, seed), seed, noise, encoder);
    spread.mean += ratio / logs;
    spread.lowest = std::min(spread.lowest, ratio);
    spread.highest = std::max(spread.highest, ratio);
    spread.near += std::abs(ratio - 1.0) < 0.15 ? 1.0 / logs : 0.0;
  }
  return spread;
}

// A log has a dozen standstills, and the position of the axis within its cell is random in each: single logs
// scatter, their mean must not.
TEST(NoiseFloor, IsTheResidualOfTheTrueModel) {
  const Spread spread = spread_over(0, 16, 1.0, 1.0);
  EXPECT_NEAR(spread.mean, 1.05, 0.1);
  EXPECT_GT(spread.lowest, 0.8);
  EXPECT_LT(spread.highest, 1.35);
  EXPECT_GT(spread.near, 0.6);
}

// Quantisation only: no noise of the force hides an error of this part. The floor does not know the true
// model: on one log of ten the elements of its fit are softer within an encoder step than the true ones
// (2.4).
TEST(NoiseFloor, CoversQuantisationByItself) {
  const Spread spread = spread_over(20, 10, 0.2, 1.0);
  EXPECT_NEAR(spread.mean, 1.2, 0.15);
  EXPECT_GT(spread.lowest, 0.85);
  EXPECT_LT(spread.highest, 2.5);
  EXPECT_GT(spread.near, 0.75);
}

// The noise of the rows is the same whatever the axis has that the models lack. (Their weights are not: rows
// that the encoder disturbs weigh more where the plain model leaves more.)
TEST(NoiseFloor, DoesNotDependOnWhatIsMissing) {
  for (std::uint64_t seed = 80; seed < 86; ++seed) {
    sim::Bench bench = bench_of(sim::Setup::kRandom, seed);
    const auto noise_N = [&] {
      Measurement measurement(test::simulate(bench, seed));
      weigh_rows(measurement);
      return std::sqrt(measurement.noise_variance().mean());
    };
    const double complete_N = noise_N();
    bench.axis.effects.viscous = sim::Viscous{20.0 * bench.axis.curve.saturation_N(), 1.0};
    bench.axis.effects.payload_kg = 0.1 * bench.axis.mass_kg;
    EXPECT_NEAR(noise_N() / complete_N, 1.0, 0.25) << seed;
  }
}

// Gear play hits after every reversal, and in a motion that repeats there is a reversal in nearly every
// interval of the time that a spectrum needs.
TEST(NoiseFloor, IsHardlyRaisedByWhatComesAgainAndAgain) {
  for (std::uint64_t seed = 80; seed < 84; ++seed) {
    sim::Bench bench = bench_of(sim::Setup::kRandom, seed);
    bench.axis.encoder_resolution_m *= 0.01;  // of the noise alone
    const double hit_N = bench.axis.curve.saturation_N();
    const auto noise_N = [&](double size_N) {
      Log log = test::simulate(bench, seed);
      for (std::size_t i = 0; i < log.force_N.size(); ++i) {
        const double since_s = std::fmod(static_cast<double>(i) / log.sample_rate_Hz, 0.7);
        if (since_s < 0.012) log.force_N[i] += size_N * std::sin(std::numbers::pi * since_s / 0.012);
      }
      Measurement measurement(log);
      weigh_rows(measurement);
      return std::sqrt(measurement.noise_variance().mean());
    };
    // Where half of the intervals are free of them, the quarter with the least is half of those.
    EXPECT_LT(noise_N(hit_N) / noise_N(0.0), 1.5) << seed;
  }
}

// What free curves leave of a delayed force is no noise, as the model with the delay shows: with it the floor
// is what it is without a delay.
TEST(NoiseFloor, IsLoweredByABetterModel) {
  for (std::uint64_t seed = 90; seed < 94; ++seed) {
    sim::Bench bench = bench_of(sim::Setup::kPickAndPlace, seed);
    bench.axis.effects.delay = sim::RecordingDelay{5e-3, 0.0};
    Measurement measurement(test::simulate(bench, seed));
    weigh_rows(measurement);
    const double by_curves_N = measurement.noise_floor_N();
    // A model that lacks the delay leaves no less room for noise than the curves alone.
    const FittedModel plain = fit_effects(measurement, default_baseline(), {});
    lower_noise_floor(measurement, *plain.linearisation);
    EXPECT_NEAR(measurement.noise_floor_N(), by_curves_N, 0.1 * by_curves_N) << seed;
    const FittedModel model =
        fit_effects(measurement, {"inertia", "presliding_hysteresis", "time_delay"}, {});
    lower_noise_floor(measurement, *model.linearisation);
    EXPECT_LT(measurement.noise_floor_N(), 0.9 * by_curves_N) << seed;
    EXPECT_GT(model.holdout_rmse_N, 0.9 * measurement.noise_floor_N()) << seed;
    EXPECT_LT(model.holdout_rmse_N, 1.35 * measurement.noise_floor_N()) << seed;
  }
}

TEST(NoiseFloor, CoversForceNoiseByItself) {
  const Spread spread = spread_over(40, 6, 3.0, 0.1);
  EXPECT_NEAR(spread.mean, 1.0, 0.03);
  EXPECT_GT(spread.lowest, 0.95);
  EXPECT_LT(spread.highest, 1.05);
}

// A drive with force noise that no sensor measures: it is in the motion, but not in the measured current. The
// residual of the true model is that noise, and the floor must contain it; without it, the floor is five
// times too low. What the controller does from sample to sample is no noise, since it is measured and moves
// the axis.
TEST(NoiseFloor, CoversForcesThatNoSensorMeasures) {
  double mean = 0.0;
  double by_sensor_only = 0.0;
  constexpr int kLogs = 16;
  for (std::uint64_t seed = 60; seed < 60 + kLogs; ++seed) {
    const sim::Bench bench = bench_of(sim::Setup::kRandom, seed);
    const sim::SimulatedLog simulated =
        sim::simulate_closed_loop_log(bench.axis, sim::draw_programme(bench, seed), bench.rate_Hz, seed);
    Measurement measurement(test::log_of(bench.axis, simulated));
    weigh_rows(measurement);
    const Terms truth = test::truth_of(measurement, bench.axis);
    const double left_N = measurement.weighted_rms(Linearisation(measurement, truth).residual_N());
    const double ratio = left_N / measurement.noise_floor_N();
    EXPECT_GT(ratio, 0.75) << seed;
    EXPECT_LT(ratio, 1.5) << seed;
    mean += ratio / kLogs;
    by_sensor_only += left_N / measurement.filtered_force_noise_N() / kLogs;
  }
  EXPECT_NEAR(mean, 1.05, 0.06);
  EXPECT_GT(by_sensor_only, 3.0) << "nothing that the sensor does not see";
}

// Given noise is not changed by the residual.
TEST(NoiseFloor, KeepsAGivenNoise) {
  const Log log = test::wandering_log(11, 1000.0, 20'000, 0.5);
  Measurement measurement(log, {.force_noise_N = 0.01});
  weigh_rows(measurement);
  EXPECT_NEAR(measurement.noise_floor_N(), measurement.filtered_force_noise_N(), 1e-12);
}

}  // namespace
}  // namespace slipstack::workbench
