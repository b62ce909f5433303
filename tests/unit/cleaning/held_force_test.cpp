// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "workbench/base/errors.h"
#include "workbench/cleaning/recorder_faults.h"
#include "workbench/cleaning/repair.h"

// A force that is recorded at a lower rate than the position.
namespace slipstack::workbench {
namespace {

Log log_with_force_held(std::size_t samples) {
  Log log;
  log.path = "log.csv";
  log.sample_rate_Hz = 1000.0;
  log.encoder_resolution_m = 1e-7;
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise_N(0.0, 0.05);
  for (std::size_t i = 0; i < 8000; ++i) {
    const double t_s = 1e-3 * static_cast<double>(i);
    log.position_m.push_back(1e-7 * std::round(1e6 * 0.1 * std::sin(2.0 * t_s)));
    const double force_N = std::copysign(3.0, std::cos(2.0 * t_s)) + noise_N(random);
    log.force_N.push_back(i % samples == 0 ? force_N : log.force_N.back());
  }
  return log;
}

TEST(HeldForce, IsRecognised) {
  EXPECT_EQ(held_samples(log_with_force_held(1).force_N), 1U);
  EXPECT_EQ(held_samples(log_with_force_held(4).force_N), 4U);
  EXPECT_EQ(held_samples(log_with_force_held(10).force_N), 10U);
  EXPECT_EQ(held_samples(std::vector<double>(1000, 2.0)), 1U) << "it never changes";
}

TEST(HeldForce, IsNotedWithItsDelay) {
  Log log = log_with_force_held(4);
  const Repairs repairs = repair(log);
  ASSERT_FALSE(repairs.notes.empty());
  EXPECT_EQ(repairs.notes.front(),
            "the force changes only every 4 samples (250 Hz): in the mean it is late by 1.50 ms");
}

TEST(HeldForce, OfTooLowARateIsRefusedWithWhatToDo) {
  Log log = log_with_force_held(10);
  try {
    repair(log);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(
        std::string(error.what()),
        "log.csv: the force changes only every 10 samples, it is recorded at 100 Hz and the position at "
        "1000 Hz; record both at one rate, or write only every 10th row");
  }
}

}  // namespace
}  // namespace slipstack::workbench
