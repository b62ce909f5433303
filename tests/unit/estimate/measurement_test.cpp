// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/measurement/measurement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <set>
#include <vector>

#include "tests/unit/estimate/estimate_support.h"

namespace slipstack::workbench {
namespace {

using test::Draw;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

// White noise on a force that follows the motion: estimated within 3 %, whatever the rest of the force.
TEST(Measurement, EstimatesTheNoiseOfTheForce) {
  double worst = 0.0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Draw draw(seed + 40);
    const double noise_N = draw.log_uniform(0.003, 1.0);
    const Measurement measurement(test::wandering_log(seed, 2000.0, 40'000, noise_N));
    worst = std::max(worst, std::abs(measurement.force_noise_N() / noise_N - 1.0));
  }
  EXPECT_LT(worst, 0.03);
}

// Friction reverses within a few samples, and drives jerk: a hundred steps of ten times the noise do not
// matter.
TEST(Measurement, EstimatesTheNoiseBesideStepsOfTheForce) {
  Draw draw(1);
  const Log log = test::log_of(
      2000.0, 40'000, [](double t) { return 0.05 * std::sin(3.0 * t); },
      [&](double t) { return (std::sin(kTwoPi * 2.5 * t) < 0.0 ? -5.0 : 5.0) + 0.5 * draw.normal(); });
  EXPECT_NEAR(Measurement(log).force_noise_N() / 0.5, 1.0, 0.03);
}

TEST(Measurement, ANoiselessForceHasNone) {
  const Measurement measurement(test::wandering_log(3, 2000.0, 20'000, 0.0));
  EXPECT_LT(measurement.force_noise_N(), 1e-6);
}

// The noise after the filter, as predicted and as found.
TEST(Measurement, PredictsTheNoiseAfterTheFilter) {
  Draw draw(4);
  const Log log = test::log_of(
      2000.0, 200'000, [](double t) { return 0.05 * std::sin(20.0 * t) + 0.01 * std::sin(57.0 * t); },
      [&](double) { return 0.3 * draw.normal(); });
  for (const double bandwidth_Hz : {8.0, 30.0, 90.0}) {
    const Measurement measurement(log, {.bandwidth_Hz = bandwidth_Hz});
    EXPECT_NEAR(test::rms(measurement.force_N()) / measurement.filtered_force_noise_N(), 1.0, 0.06)
        << bandwidth_Hz;
  }
}

double bandwidth_with_steps_Hz(double encoder_m) {
  Log log = test::wandering_log(5, 4000.0, 160'000);
  log.mass_kg = 4.0;
  log.encoder_resolution_m = encoder_m;
  return Measurement(log).bandwidth_Hz();
}

// A force of 2.1 N (standard deviation). The steps of the encoder, multiplied by 4 kg, are 2 % of it within
// 20 Hz where they are 50 um, within 124 Hz where they are 0.5 um; a hundredth of the rate suffices.
TEST(Measurement, TheEncodersStepsAreASmallPartOfTheForce) {
  const double coarse_Hz = bandwidth_with_steps_Hz(50e-6);
  const double omega2_per_s2 = std::pow(2.0 * std::numbers::pi * coarse_Hz, 2);
  // White noise of an LSB / sqrt(12), differentiated twice: density 4 LSB^2 / 12 w^4 / rate.
  const double steps_N =
      4.0 * 50e-6 * omega2_per_s2 / std::sqrt(12.0) * std::sqrt(2.0 * coarse_Hz / 4000.0 / 5.0);
  EXPECT_NEAR(steps_N, 0.02 * 3.0 / std::numbers::sqrt2, 2e-3);
  EXPECT_DOUBLE_EQ(bandwidth_with_steps_Hz(0.5e-6), 40.0);
  EXPECT_DOUBLE_EQ(bandwidth_with_steps_Hz(50e-3), 4.0);
}

// A motion whose period is as long as the blocks of all folds: each of them would leave out the same part of
// every repetition, which no other fit has seen.
TEST(Measurement, EachFoldSeesAllPartsOfAMotionThatRepeats) {
  constexpr double kSeconds = 60.0;
  for (const double period_s : {10.0, 5.0, 9.9, 4.0, 7.3}) {
    const Log log = test::log_of(
        500.0, static_cast<std::size_t>(500.0 * kSeconds),
        [&](double t) {
          return 0.05 * std::sin(kTwoPi * t / period_s) + 0.02 * std::sin(3.0 * kTwoPi * t / period_s + 1.0);
        },
        [](double t) { return std::sin(3.1 * t); });
    const Measurement measurement(log);
    constexpr int kParts = 10;  // of a period
    std::array<std::set<int>, kParts> folds;
    for (std::size_t row = 0; row < measurement.row_blocks().size(); ++row) {
      const double time_s = measurement.time_s(measurement.row_samples()[row]);
      const double share = time_s / period_s - std::floor(time_s / period_s);
      folds[static_cast<std::size_t>(share * kParts)].insert(
          measurement.fold_of_block(measurement.row_blocks()[row]));
    }
    for (const std::set<int>& of_part : folds) EXPECT_GE(of_part.size(), 2u) << period_s;
  }
}

TEST(Measurement, RecoversASmoothMotion) {
  const double w = kTwoPi * 3.0;
  const Log log = test::log_of(
      2000.0, 8000, [&](double t) { return 0.02 * std::sin(w * t); },
      [](double t) { return std::sin(40.0 * t); });
  const Measurement measurement(log, {.bandwidth_Hz = 40.0});
  for (const std::size_t i : measurement.row_samples()) {
    const double t = static_cast<double>(i) / 2000.0;
    EXPECT_NEAR(measurement.position_m()[i], 0.02 * std::sin(w * t), 1e-3 * 0.02);
    EXPECT_NEAR(measurement.velocity_mps()[i], 0.02 * w * std::cos(w * t), 1e-3 * 0.02 * w);
    EXPECT_NEAR(measurement.acceleration_mps2()[i], -0.02 * w * w * std::sin(w * t), 1e-3 * 0.02 * w * w);
    const Sample<double> sample = measurement.sample(i);
    EXPECT_EQ(sample.time_s, static_cast<double>(i) * measurement.tick_s());
    EXPECT_EQ(sample.velocity_mps, measurement.velocity_mps()[i]);
    EXPECT_NEAR(sample.displacement, 0.02 * std::sin(w * t), 1e-3 * 0.02);
  }
}

// Force and regressors pass one filter: filtered() is the sum with taps() around each row, both stages
// together.
TEST(Measurement, FiltersByItsTapsAtTheRows) {
  for (const double bandwidth_Hz : {5.0, 33.0, 100.0, 400.0}) {
    const Measurement measurement(test::wandering_log(5, 2000.0, 9000), {.bandwidth_Hz = bandwidth_Hz});
    Draw draw(6);
    std::vector<double> signal(measurement.sample_count());
    for (double& value : signal) value = draw.normal();
    const Eigen::VectorXd is = measurement.filtered(signal);
    const std::vector<double>& taps = measurement.filter().taps();
    const std::size_t half = taps.size() / 2;
    double sum_of_taps = 0.0;
    for (const double tap : taps) sum_of_taps += tap;
    EXPECT_NEAR(sum_of_taps, 1.0, 1e-12);
    for (std::size_t k = 0; k < taps.size(); ++k) EXPECT_NEAR(taps[k], taps[taps.size() - 1 - k], 1e-15);
    ASSERT_GT(measurement.row_count(), 20);
    for (Eigen::Index row = 0; row < is.size(); ++row) {
      const std::size_t centre = measurement.row_samples()[static_cast<std::size_t>(row)];
      double should = 0.0;
      for (std::size_t k = 0; k < taps.size(); ++k) should += taps[k] * signal[centre + k - half];
      ASSERT_NEAR(is(row), should, 1e-12) << bandwidth_Hz << ' ' << row;
    }
  }
}

// In the band of the motion the two stages together are flat; beyond, what comes through is what the first
// stage, a triangular mean of few samples, lets through at its images.
TEST(Measurement, TheRowFilterPassesTheMotion) {
  for (const double bandwidth_Hz : {5.0, 33.0, 100.0}) {
    const RowFilter filter(bandwidth_Hz, 2000.0);
    const auto response = [&](double frequency_Hz) {
      std::complex<double> sum;
      const std::size_t half = filter.taps().size() / 2;
      for (std::size_t k = 0; k < filter.taps().size(); ++k) {
        sum += filter.taps()[k] * std::polar(1.0, kTwoPi * frequency_Hz / 2000.0 *
                                                      (static_cast<double>(k) - static_cast<double>(half)));
      }
      return std::abs(sum);
    };
    EXPECT_NEAR(response(0.0), 1.0, 1e-12);
    EXPECT_GT(response(0.5 * bandwidth_Hz), 0.97);
    EXPECT_NEAR(response(bandwidth_Hz), 0.48, 0.03);
    double near = 0.0;
    double far = 0.0;
    for (double f = 1.6 * bandwidth_Hz; f < 1000.0; f += 0.1 * bandwidth_Hz) {
      double& band = f < 4.4 * bandwidth_Hz ? near : far;
      band = std::max(band, response(f));
    }
    EXPECT_LT(near, 3e-4) << bandwidth_Hz;
    EXPECT_LT(far, 0.05) << bandwidth_Hz;
  }
}

// A force recorded with a delay tau: the measurement compensates it.
TEST(Measurement, DelayShiftsTheForce) {
  const auto force_at = [](double t) { return 4.0 * std::sin(31.0 * t) + std::cos(77.0 * t + 0.4); };
  const auto position_at = [](double t) { return 0.05 * std::sin(9.0 * t); };
  const Measurement prompt(test::log_of(2000.0, 8000, position_at, force_at), {.bandwidth_Hz = 60.0});
  for (const double delay_s : {5e-4, 2.31e-3, -7.7e-4, 0.0187}) {
    const Measurement late(
        test::log_of(2000.0, 8000, position_at, [&](double t) { return force_at(t - delay_s); }),
        {.bandwidth_Hz = 60.0});
    const Eigen::Index rows = prompt.row_count() - 2;  // at the end of a record there are no later samples
    const Eigen::VectorXd error = (late.force_N({delay_s}) - prompt.force_N()).head(rows);
    EXPECT_LT(error.norm(), 2e-5 * prompt.force_N().norm()) << delay_s;
    EXPECT_GT((late.force_N() - prompt.force_N()).norm(), 0.01 * prompt.force_N().norm());
  }
  EXPECT_EQ(prompt.force_N({0.0, 0.0}), prompt.force_N());
}

// A wave through a first-order low pass, in closed form: the measurement compensates the low pass.
TEST(Measurement, UndoesALowPassOfTheForce) {
  const auto position_at = [](double t) { return 0.05 * std::sin(9.0 * t); };
  const auto wave = [](double t, double w, double T) {
    return std::sin(w * t - std::atan(w * T)) / std::hypot(1.0, w * T);
  };
  const auto recorded = [&](double T, double delay_s) {
    return Measurement(
        test::log_of(2000.0, 8000, position_at,
                     [&](double t) { return 4.0 * wave(t - delay_s, 31.0, T) + wave(t - delay_s, 77.0, T); }),
        {.bandwidth_Hz = 60.0});
  };
  const Measurement prompt = recorded(0.0, 0.0);
  const Eigen::Index rows = prompt.row_count() - 2;
  for (const double T : {2e-4, 1.7e-3, 0.012}) {
    const Measurement late = recorded(T, 6e-4);
    const Eigen::VectorXd error = (late.force_N({6e-4, T}) - prompt.force_N()).segment(2, rows - 2);
    EXPECT_LT(error.norm(), 2e-5 * prompt.force_N().norm()) << T;
    const Eigen::VectorXd delayed = (late.force_N({6e-4 + T}) - prompt.force_N()).segment(2, rows - 2);
    EXPECT_GT(delayed.norm(), 3.0 * error.norm()) << T;
  }
}

TEST(Measurement, PredictsTheAmplifiedNoiseOfTheForce) {
  test::Draw draw(11);
  const Measurement noise(test::log_of(
                              2000.0, 60'000, [](double t) { return 0.05 * std::sin(9.0 * t); },
                              [&](double) { return draw.normal(); }),
                          {.bandwidth_Hz = 60.0});
  for (const MeasurementDynamics lag :
       {MeasurementDynamics{}, MeasurementDynamics{0.0, 1e-3}, MeasurementDynamics{0.0, 5e-3}}) {
    EXPECT_NEAR(test::rms(noise.force_N(lag)) / noise.force_noise_gain(lag), 1.0, 0.03) << lag.filter_s;
  }
  EXPECT_GT(noise.force_noise_gain({0.0, 5e-3}), 1.3 * noise.force_noise_gain({}));
}

TEST(Measurement, RowsLieWithinTheRecord) {
  for (const std::size_t count : {400u, 2000u, 30'000u}) {
    const Measurement measurement(test::wandering_log(7, 1000.0, count));
    const std::size_t half = measurement.filter().taps().size() / 2;
    std::size_t previous = 0;
    for (const std::size_t sample : measurement.row_samples()) {
      EXPECT_GE(sample, half);
      EXPECT_LT(sample + half, measurement.sample_count());
      EXPECT_TRUE(previous == 0 || sample == previous + measurement.row_stride());
      previous = sample;
    }
  }
}

TEST(Measurement, KeepsAtMostTheMaximumOfRows) {
  const Log log = test::wandering_log(8, 2000.0, 60'000);
  const Measurement all(log, {.bandwidth_Hz = 100.0});
  const Measurement few(log, {.bandwidth_Hz = 100.0, .maximum_rows = 500});
  EXPECT_GT(all.row_count(), 5000);
  EXPECT_LE(few.row_count(), 500);
  EXPECT_GT(few.row_count(), 400);
}

// The same motion read by an encoder with a shifted grid: as different from the first reading as two readings
// are, and never by more than their cells.
TEST(Measurement, ARealisationIsAnotherReading) {
  constexpr double kResolution_m = 1e-6;
  Log log = test::wandering_log(9, 2000.0, 20'000);
  for (double& x : log.position_m) x = std::floor(x / kResolution_m + 0.5) * kResolution_m;
  log.encoder_resolution_m = kResolution_m;
  const Measurement measurement(log);
  const Measurement other = measurement.with_realisation({.shift_steps = 0.382});
  double sum = 0.0;
  double largest = 0.0;
  for (std::size_t i = 0; i < measurement.sample_count(); ++i) {
    const double apart = other.sample(i).displacement - measurement.sample(i).displacement;
    sum += apart * apart;
    largest = std::max(largest, std::abs(apart));
  }
  const double rms = std::sqrt(sum / static_cast<double>(measurement.sample_count()));
  EXPECT_LT(largest, 1.01 * kResolution_m);
  EXPECT_LT(rms, kResolution_m / std::sqrt(12.0));
  EXPECT_GT(rms, 0.1 * kResolution_m / std::sqrt(12.0));
}

/// Number of turning points between samples, in a realisation of the log.
std::size_t turning_points_in(const std::vector<double>& position_m, double beyond_corners) {
  Log log = test::wandering_log(9, 2000.0, position_m.size());
  log.position_m = position_m;
  log.encoder_resolution_m = 1e-6;
  const Measurement measurement = Measurement(log).with_realisation({.beyond_corners = beyond_corners});
  return measurement.turning_points(0, measurement.sample_count()).size();
}

// A zigzag from sample to sample may be faster than the sampling; slow oscillations and movements are
// observed.
TEST(Measurement, AZigzagMayGoBeyondItsCorners) {
  std::vector<double> zigzag = test::wandering_log(9, 2000.0, 20'000).position_m;
  for (double& x : zigzag) x = std::floor(x / 1e-6 + 0.5) * 1e-6;
  const std::vector<double> moves = zigzag;
  for (std::size_t i = 8000; i < 9000; ++i) zigzag[i] = zigzag[8000] + (i % 2 == 0 ? 0.0 : 3e-6);
  EXPECT_EQ(turning_points_in(zigzag, 0.0), turning_points_in(moves, 0.0));
  EXPECT_GT(turning_points_in(zigzag, 0.5), turning_points_in(moves, 0.5) + 900);

  Log log = test::wandering_log(9, 2000.0, 20'000);
  log.position_m = zigzag;
  log.encoder_resolution_m = 1e-6;
  const Measurement measurement = Measurement(log).with_realisation({.beyond_corners = 0.5});
  for (const TurningPoint& point : measurement.turning_points(8100, 800)) {
    const double low_m = zigzag[8000];
    const bool above = point.displacement_m > low_m + 1.5e-6;
    EXPECT_NEAR(point.displacement_m, above ? low_m + 4.5e-6 : low_m - 1.5e-6, 1.01e-6);
  }
}

TEST(Measurement, WeightsAreOneUntilTheyAreSet) {
  Measurement measurement(test::wandering_log(10, 1000.0, 6000));
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(measurement.row_count());
  EXPECT_EQ(measurement.row_weights(), ones);
  Draw draw(11);
  const Eigen::VectorXd rows = draw.matrix(measurement.row_count(), 1);
  EXPECT_NEAR(measurement.weighted_rms(rows), test::rms(rows), 1e-14);
  Eigen::VectorXd weights = ones;
  weights.head(weights.size() / 2).setZero();
  measurement.set_row_weights(weights);
  const Eigen::VectorXd tail = rows.tail(rows.size() - rows.size() / 2);
  EXPECT_NEAR(measurement.weighted_rms(rows), test::rms(tail), 1e-14);
}

}  // namespace
}  // namespace slipstack::workbench
