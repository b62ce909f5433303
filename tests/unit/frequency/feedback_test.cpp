// SPDX-License-Identifier: Apache-2.0
// The response of the drive's feedback against the firmware's own code, run in time.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "firmware/control/force/feedback.h"
#include "firmware/control/force/state_estimate.h"
#include "workbench/frequency/drive_controller.h"

namespace slipstack::workbench {
namespace {

/// Force over position of the firmware's estimate and feedback, at a harmonic of 4096 ticks.
Complex run_firmware(const DriveController& drive, int line) {
  constexpr int kPeriod = 4096;
  constexpr double kAmplitude_counts = 1e6;
  const auto tick_s = static_cast<float>(drive.tick_s);
  constexpr float kResolution_m = 1e-8F;
  const auto estimate_gains =
      StateEstimate::gains(kResolution_m, tick_s, static_cast<float>(drive.observer_rad_per_s));
  Feedback::Gains gains;
  gains.resolution_m = kResolution_m;
  gains.mps_per_count = kResolution_m / tick_s;
  gains.position_per_s = static_cast<float>(drive.position_gain_per_s);
  gains.velocity_N_s_per_m = static_cast<float>(drive.velocity_gain_N_s_per_m);
  gains.integral_per_tick = static_cast<float>(drive.integral_per_s) * tick_s;
  for (std::size_t i = 0; i < 2; ++i) {
    const DriveNotch& notch = drive.notch[i];
    gains.notch[i] = Notch::gains(static_cast<float>(notch.frequency_Hz), static_cast<float>(notch.damping),
                                  static_cast<float>(notch.depth), tick_s);
  }
  StateEstimate estimate;
  Feedback feedback;
  float expected_mps2 = 0.0F;
  Complex y = 0.0;
  Complex force_sum = 0.0;
  const auto mass_kg = static_cast<float>(drive.mass_kg);
  for (int k = 0; k < 12 * kPeriod; ++k) {
    const double angle = 2.0 * std::numbers::pi * line * (k % kPeriod) / kPeriod;
    const auto counts = static_cast<std::int32_t>(std::lround(kAmplitude_counts * std::sin(angle)));
    estimate.step(estimate_gains, counts, expected_mps2);
    const float error_m = Feedback::error_m(gains, {}, estimate);
    const float fed_N = feedback.step(gains, {}, error_m, estimate.velocity_mps());
    const float force_N =
        fed_N - static_cast<float>(drive.disturbance_share) * mass_kg * estimate.disturbance_mps2();
    feedback.integrate(gains, force_N, force_N);
    expected_mps2 = force_N / mass_kg;
    if (k < 11 * kPeriod) continue;
    y += static_cast<double>(counts) * 1e-8 * std::polar(1.0, -angle);
    force_sum += static_cast<double>(force_N) * std::polar(1.0, -angle);
  }
  return force_sum / y;
}

TEST(FeedbackResponse, IsThatOfTheFirmware) {
  std::mt19937_64 random(3);
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<>()(random));
  };
  for (int i = 0; i < 20; ++i) {
    DriveController drive;
    drive.mass_kg = between(5.0, 50.0);
    drive.observer_rad_per_s = between(200.0, 2000.0);
    drive.velocity_gain_N_s_per_m = drive.mass_kg * between(20.0, 200.0);
    drive.position_gain_per_s = between(5.0, 60.0);
    drive.integral_per_s = between(5.0, 60.0);
    drive.disturbance_share = i % 3 == 0 ? 0.3 : 0.0;
    if (i % 2 == 0) drive.notch[0] = {between(50.0, 500.0), 0.3, 0.1};
    if (i % 4 == 0) drive.notch[1] = {between(50.0, 500.0), 0.2, 0.05};
    const int line = static_cast<int>(between(4.0, 400.0));
    ResponsePoint point;
    point.frequency_Hz = line / (4096.0 * drive.tick_s);
    const Complex wanted = -run_firmware(drive, line);
    const Complex found = FeedbackResponse(drive, {point}).of(drive)[0];
    EXPECT_LT(std::abs(found / wanted - 1.0), 0.01) << i << " line " << line;
  }
}

}  // namespace
}  // namespace slipstack::workbench
