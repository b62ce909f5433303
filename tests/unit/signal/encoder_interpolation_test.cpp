// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/encoder_interpolation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace slipstack::workbench {
namespace {

constexpr double kEncoderStep_m = 1e-6;

std::vector<double> read(const std::vector<double>& position_m, double phase = 0.0) {
  std::vector<double> reading;
  for (const double x : position_m) {
    reading.push_back((std::floor(x / kEncoderStep_m + 0.5 + phase) - phase) * kEncoderStep_m);
  }
  return reading;
}

double rms_error(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

/// A slow loop of pre-sliding: `amplitude_m` in `period` samples.
std::vector<double> loop(double amplitude_m, double period, std::size_t count, double phase) {
  std::vector<double> position;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / period + phase;
    position.push_back(amplitude_m * (std::sin(angle) + 0.2 * std::sin(2.7 * angle)));
  }
  return position;
}

const double kPlain_m = kEncoderStep_m / std::sqrt(12.0);

// The rms error of a reading is resolution / sqrt(12); where many samples fall into a cell it must be
// smaller.
TEST(EncoderInterpolation, IsFinerThanTheGridWhereTheAxisIsSlow) {
  double worst = 0.0;
  double mean = 0.0;
  for (int k = 0; k < 20; ++k) {
    const std::vector<double> truth = loop((10.0 + k) * 1e-6, 2000.0, 10'000, 0.3 * k);
    const std::vector<double> reading = read(truth, 0.05 * k);
    EXPECT_NEAR(rms_error(reading, truth) / kPlain_m, 1.0, 0.05);
    const double error = rms_error(interpolate_between_steps(reading, kEncoderStep_m), truth) / kPlain_m;
    worst = std::max(worst, error);
    mean += error / 20.0;
  }
  EXPECT_LT(worst, 0.5);
  EXPECT_LT(mean, 0.25);
  EXPECT_GT(mean, 0.02);
}

// A steady creep is reproduced exactly, except for the resolution in time of the crossings.
TEST(EncoderInterpolation, FollowsASteadyCreep) {
  std::vector<double> truth;
  for (int i = 0; i < 20'000; ++i) truth.push_back(0.0137e-6 * i + 0.21e-6);
  const std::vector<double> is = interpolate_between_steps(read(truth), kEncoderStep_m);
  double worst = 0.0;
  for (std::size_t i = 200; i + 200 < truth.size(); ++i) worst = std::max(worst, std::abs(is[i] - truth[i]));
  EXPECT_LT(worst, 0.05 * kEncoderStep_m);
}

TEST(EncoderInterpolation, NeverLeavesTheCell) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  for (const double speed : {1e-9, 1e-8, 1e-7, 1e-6, 1e-5}) {
    std::vector<double> truth{0.0};
    double velocity = 0.0;
    for (int i = 1; i < 20'000; ++i) {
      velocity += 0.05 * (speed * normal(random) - velocity);
      truth.push_back(truth.back() + velocity);
    }
    const std::vector<double> reading = read(truth);
    const std::vector<double> is = interpolate_between_steps(reading, kEncoderStep_m);
    ASSERT_EQ(is.size(), reading.size());
    for (std::size_t i = 0; i < is.size(); ++i) {
      ASSERT_LE(std::abs(is[i] - reading[i]), 0.5 * kEncoderStep_m * (1.0 + 1e-9)) << speed << ' ' << i;
    }
  }
}

// With several cells in every sample the readings cannot be improved.
TEST(EncoderInterpolation, KeepsReadingsWhereTheAxisIsFast) {
  std::vector<double> truth;
  for (int i = 0; i < 1000; ++i) truth.push_back(3.7e-6 * i);
  const std::vector<double> reading = read(truth);
  EXPECT_EQ(interpolate_between_steps(reading, kEncoderStep_m), reading);
}

TEST(EncoderInterpolation, KeepsReadingsThatAreOnNoGrid) {
  const std::vector<double> smooth = loop(20e-6, 1000.0, 3000, 0.0);
  EXPECT_EQ(interpolate_between_steps(smooth, 0.0), smooth);
  EXPECT_EQ(interpolate_between_steps(smooth, -1.0), smooth);
  // A declared resolution does not hurt readings that are finer than it.
  EXPECT_EQ(interpolate_between_steps(smooth, kEncoderStep_m), smooth);
}

// A fast move ends somewhere in a cell and the axis stands still there. The readings show only that it
// stopped within the cell, so the best estimate is the middle. (A cubic through the borders with the speed of
// the move would reach a border and stay there.)
TEST(EncoderInterpolation, DwellsInTheMiddleOfTheCell) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(0.0, 200e-6);
  std::vector<double> truth;
  std::vector<std::size_t> dwelling;
  double from = place(random);
  for (int move = 0; move < 200; ++move) {
    const double to = place(random);
    for (int i = 0; i < 300; ++i) {
      const double u = std::min(1.0, i / 100.0);
      truth.push_back(from + (to - from) * u * u * u * (10.0 + u * (6.0 * u - 15.0)));
      if (i > 120) dwelling.push_back(truth.size() - 1);
    }
    from = to;
  }
  const std::vector<double> is = interpolate_between_steps(read(truth), kEncoderStep_m);
  double sum = 0.0;
  for (const std::size_t i : dwelling) sum += (is[i] - truth[i]) * (is[i] - truth[i]);
  const double error = std::sqrt(sum / static_cast<double>(dwelling.size())) / kPlain_m;
  EXPECT_LT(error, 1.1);
  EXPECT_GT(error, 0.6);
}

TEST(EncoderInterpolation, KeepsTheReadingAtAStandstill) {
  const std::vector<double> still(500, 3e-6);
  for (const double x : interpolate_between_steps(still, kEncoderStep_m)) EXPECT_NEAR(x, 3e-6, 1e-20);
}

TEST(EncoderInterpolation, IsSymmetricInSpaceAndTime) {
  const std::vector<double> truth = loop(15e-6, 1500.0, 4000, 1.0);
  std::vector<double> reading = read(truth);
  std::vector<double> forward = interpolate_between_steps(reading, kEncoderStep_m);
  for (double& x : reading) x = -x;
  const std::vector<double> mirrored = interpolate_between_steps(reading, kEncoderStep_m);
  for (std::size_t i = 0; i < forward.size(); ++i) EXPECT_NEAR(mirrored[i], -forward[i], 1e-18);
  const std::vector<double> backward(reading.rbegin(), reading.rend());
  const std::vector<double> reversed = interpolate_between_steps(backward, kEncoderStep_m);
  for (std::size_t i = 0; i < forward.size(); ++i) {
    EXPECT_NEAR(reversed[forward.size() - 1 - i], mirrored[i], 1e-15) << i;
  }
}

/// A motion that arrives fast, stays within a cell for long, and leaves by the same border or the other one.
std::vector<double> stay(std::size_t samples, double leaves_by) {
  std::vector<double> truth;
  truth.reserve(samples + 800);
  for (int i = 0; i < 400; ++i) truth.push_back(-0.05e-6 * (400 - i) - 0.49e-6);
  for (std::size_t i = 0; i < samples; ++i) truth.push_back(0.2e-6);
  for (int i = 1; i < 400; ++i) truth.push_back((0.49e-6 + 0.05e-6 * i) * leaves_by);
  return truth;
}

// The alternative motion replaces the cubic in a long, unsteady stay only, not near crossings and not in a
// short or steady stay.
TEST(EncoderInterpolation, UsesTheAlternativeMotionOnlyWhereReadingsLeaveItOpen) {
  const UnobservedMotion early{.longest_known = 100.0, .places = {0.9, 0.1}};
  for (const double leaves_by : {1.0, -1.0}) {
    const std::vector<double> reading = read(stay(1000, leaves_by));
    const std::vector<double> by_cubic = interpolate_between_steps(reading, kEncoderStep_m);
    const std::vector<double> alternative = interpolate_between_steps(reading, kEncoderStep_m, early);
    double furthest = 0.0;
    for (std::size_t i = 0; i < reading.size(); ++i) {
      EXPECT_LE(std::abs(alternative[i] - reading[i]), 0.5001 * kEncoderStep_m);
      if (i < 380 || i > 1420) {
        EXPECT_EQ(alternative[i], by_cubic[i]);
      }
      furthest = std::max(furthest, std::abs(alternative[i] - by_cubic[i]));
    }
    EXPECT_GT(furthest, 0.3 * kEncoderStep_m);
    EXPECT_NEAR(alternative[400 + 333], 0.4 * kEncoderStep_m, 0.02 * kEncoderStep_m);
    EXPECT_NEAR(alternative[400 + 667], -0.4 * kEncoderStep_m, 0.02 * kEncoderStep_m);
    const std::vector<double> brief = read(stay(40, leaves_by));
    EXPECT_EQ(interpolate_between_steps(brief, kEncoderStep_m, early),
              interpolate_between_steps(brief, kEncoderStep_m));
  }
  std::vector<double> creep;
  creep.reserve(20'000);
  for (int i = 0; i < 20'000; ++i) creep.push_back(0.0031e-6 * i + 0.21e-6);
  const std::vector<double> slow = read(creep);
  const std::vector<double> is = interpolate_between_steps(slow, kEncoderStep_m, early);
  const std::vector<double> by_cubic = interpolate_between_steps(slow, kEncoderStep_m);
  for (std::size_t i = 700; i + 700 < is.size(); ++i) EXPECT_EQ(is[i], by_cubic[i]);
}

TEST(EncoderInterpolation, DoesNotChangeShortRecords) {
  for (std::size_t count = 0; count < 3; ++count) {
    const std::vector<double> few(count, 1e-6);
    EXPECT_EQ(interpolate_between_steps(few, kEncoderStep_m), few);
  }
}

}  // namespace
}  // namespace slipstack::workbench
