// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "sim_host/rng.h"
#include "sim_host/sensors/delay_line.h"
#include "sim_host/sensors/encoder.h"
#include "sim_host/sensors/low_pass.h"
#include "sim_host/sensors/ringing_mode.h"

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

// The departure from a ramp that begins: −2ζ/ω slope at last, and until then the free motion, in closed form.
TEST(RingingMode, MeetsTheExactRampResponse) {
  constexpr double kRate_per_s = 2.0 * std::numbers::pi * 300.0;
  for (const double damping : {0.0, 0.004, 0.04, 0.3}) {
    RingingMode mode(1e-4, 300.0, damping);
    EXPECT_EQ(mode.push(2.0), 0.0);
    const double damped_per_s = kRate_per_s * std::sqrt(1.0 - damping * damping);
    for (int i = 1; i < 500; ++i) {
      const double t = i * 1e-4;
      const double lag_s = 2.0 * damping / kRate_per_s;
      const double phase = damped_per_s * t;
      const double free_s =
          std::exp(-damping * kRate_per_s * t) *
          (lag_s * std::cos(phase) + (damping * kRate_per_s * lag_s - 1.0) / damped_per_s * std::sin(phase));
      ASSERT_NEAR(mode.push(2.0 + 5.0 * t), 5.0 * (free_s - lag_s), 1e-12) << damping << " " << i;
    }
  }
}

TEST(RingingMode, KeepsAConstantAndRefusesWhatIsNoMode) {
  RingingMode mode(1e-3, 120.0, 0.01);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(mode.push(7.0), 0.0);
  EXPECT_THROW(RingingMode(0.0, 120.0, 0.01), std::invalid_argument);
  EXPECT_THROW(RingingMode(1e-3, 0.0, 0.01), std::invalid_argument);
  EXPECT_THROW(RingingMode(1e-3, 120.0, 1.0), std::invalid_argument);
}

// The gain of Butterworth, and the phase: none both ways, and that of its poles once.
TEST(LowPass, HasTheGainOfButterworth) {
  constexpr double kRate_Hz = 2000.0;
  constexpr double kCut_Hz = 20.0;
  for (const int order : {2, 4}) {
    for (const bool zero_phase : {false, true}) {
      for (const double frequency_Hz : {2.0, 10.0, 20.0, 40.0}) {
        std::vector<double> sine(8000);
        for (std::size_t i = 0; i < sine.size(); ++i)
          sine[i] = std::sin(2.0 * std::numbers::pi * frequency_Hz / kRate_Hz * static_cast<double>(i));
        const std::vector<double> smooth = low_passed(sine, kRate_Hz, kCut_Hz, order, zero_phase);
        // Over whole periods in the middle.
        double in_phase = 0.0;
        double across = 0.0;
        for (std::size_t i = 3000; i < 5000; ++i) {
          const double phase = 2.0 * std::numbers::pi * frequency_Hz / kRate_Hz * static_cast<double>(i);
          in_phase += smooth[i] * std::sin(phase) / 1000.0;
          across += smooth[i] * std::cos(phase) / 1000.0;
        }
        const double square = 1.0 / (1.0 + std::pow(frequency_Hz / kCut_Hz, 2 * order));
        EXPECT_NEAR(std::hypot(in_phase, across), zero_phase ? square : std::sqrt(square), 3e-3)
            << order << " " << frequency_Hz;
        if (zero_phase) {
          EXPECT_NEAR(across, 0.0, 1e-6) << order << " " << frequency_Hz;
        } else if (frequency_Hz == kCut_Hz) {
          EXPECT_NEAR(in_phase, std::cos(0.25 * std::numbers::pi * order) / std::sqrt(2.0), 1e-3) << order;
          EXPECT_NEAR(across, -std::sin(0.25 * std::numbers::pi * order) / std::sqrt(2.0), 1e-3) << order;
        }
      }
    }
  }
}

TEST(LowPass, KeepsAConstantAndRefusesACutBeyondNyquist) {
  for (const double value : low_passed(std::vector<double>(300, 7.0), 1000.0, 10.0, 4, true))
    ASSERT_NEAR(value, 7.0, 1e-9);
  EXPECT_TRUE(low_passed({}, 1000.0, 10.0, 2, true).empty());
  EXPECT_THROW(low_passed({1.0}, 1000.0, 500.0, 2, true), std::invalid_argument);
  EXPECT_THROW(low_passed({1.0}, 1000.0, 10.0, 3, true), std::invalid_argument);
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
