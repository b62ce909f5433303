// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim_host/rng.h"
#include "sim_host/sensors/delay_line.h"
#include "sim_host/sensors/encoder.h"

namespace slipstack::sim {
namespace {

TEST(Encoder, RoundsToTheNearestCount) {
  Rng rng(1);
  for (const double resolution : {1e-8, 1e-7, 1e-6}) {
    const Encoder encoder(resolution);
    double sum = 0.0;
    double squares = 0.0;
    constexpr int kCount = 200000;
    for (int i = 0; i < kCount; ++i) {
      const double x = rng.uniform(-0.2, 0.5);
      const double error = (encoder.position_m(x) - x) / resolution;
      ASSERT_LE(std::fabs(error), 0.5 + 1e-6);
      sum += error;
      squares += error * error;
    }
    // Uniform rounding error: mean 0, variance 1/12.
    EXPECT_NEAR(sum / kCount, 0.0, 0.003);
    EXPECT_NEAR(squares / kCount * 12.0, 1.0, 0.01);
  }
}

TEST(Encoder, CountsUpThroughZero) {
  const Encoder encoder(1e-6);
  for (int count = -1000; count <= 1000; ++count) {
    EXPECT_EQ(encoder.counts(count * 1e-6), count);
    EXPECT_EQ(encoder.counts((count + 0.49) * 1e-6), count);
    EXPECT_EQ(encoder.counts((count + 0.51) * 1e-6), count + 1);
  }
}

TEST(Encoder, LosesCountsFromTheirTimeOn) {
  Encoder encoder(1e-6, 0.25);
  encoder.set_slip({{{1.0, 40.0}, {2.0, 5.0}}});
  EXPECT_EQ(encoder.counts(1e-3, 0.999), 1000);
  EXPECT_EQ(encoder.counts(1e-3, 1.0), 960);
  EXPECT_EQ(encoder.counts(1e-3, 2.5), 955);
}

TEST(Encoder, WithoutResolutionIsTrue) {
  EXPECT_EQ(Encoder(0.0).position_m(0.123456789), 0.123456789);
}

TEST(DelayLine, DelaysASineByAFractionOfAStep) {
  for (const double delay_s : {0.0, 0.3e-3, 1.0e-3, 1.7e-3, 5.25e-3}) {
    DelayLine line(1e-3, delay_s, 0.0);
    const double w = 2.0 * std::numbers::pi * 20.0;
    for (int i = 0; i < 400; ++i) {
      const double late = line.push(std::sin(w * i * 1e-3));
      // Third order: error below (wh)⁴/24 ~ 1e-5.
      if (i > 20) {
        ASSERT_NEAR(late, std::sin(w * (i * 1e-3 - delay_s)), 3e-4) << delay_s;
      }
    }
  }
}

TEST(DelayLine, FilterMeetsTheExactRampResponse) {
  DelayLine line(1e-3, 0.0, 4e-3);
  for (int i = 0; i < 200; ++i) {
    const double t = i * 1e-3;
    // Lag of a ramp: t − τ·(1 − exp(−t/τ)).
    ASSERT_NEAR(line.push(t), t - 4e-3 * -std::expm1(-t / 4e-3), 1e-15);
  }
}

TEST(DelayLine, KeepsAConstant) {
  DelayLine line(1e-3, 2.4e-3, 1e-3);
  for (int i = 0; i < 50; ++i) EXPECT_NEAR(line.push(7.0), 7.0, 1e-13);
}

TEST(DelayLine, RefusesNegativeTimes) {
  EXPECT_THROW(DelayLine(1e-3, -1e-3, 0.0), std::invalid_argument);
  EXPECT_THROW(DelayLine(0.0, 0.0, 0.0), std::invalid_argument);
}

TEST(Rng, IsTheSameEverywhereAndItsStreamsDiffer) {
  // Recorded when written; a change here changes every simulated log.
  Rng first(1, "axis");
  Rng same(1, "axis");
  Rng other(1, "noise");
  const double a = first.uniform();
  EXPECT_EQ(a, same.uniform());
  EXPECT_NE(a, other.uniform());
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const double x = first.normal();
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / 200000, 0.0, 0.01);
  EXPECT_NEAR(squares / 200000, 1.0, 0.015);
}

}  // namespace
}  // namespace slipstack::sim
