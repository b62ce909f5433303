// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/held_position.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/draw.h"

// A position that is recorded at a lower rate than the log has.
namespace slipstack::workbench {
namespace {

constexpr double kStep_m = 1e-6;

/// A position that is new at every `period`-th sample from `first` on.
Log log_with_position_held(std::size_t period, std::size_t first) {
  Log log;
  log.path = "log.csv";
  log.sample_rate_Hz = 1000.0;
  log.encoder_resolution_m = kStep_m;
  test::Draw draw(9);
  for (std::size_t i = 0; i < 8000; ++i) {
    const double t_s = 1e-3 * static_cast<double>(i);
    const double x_m = 0.1 * std::sin(2.0 * t_s) + 0.02 * std::sin(7.0 * t_s);
    const bool is_new = i % period == first || i == 0;
    log.position_m.push_back(is_new ? kStep_m * std::round(x_m / kStep_m) : log.position_m.back());
    log.force_N.push_back(draw.normal());
  }
  return log;
}

TEST(HeldPosition, OnlyTheRowsInWhichItIsNewAreKept) {
  const Log before = log_with_position_held(4, 2);
  Log log = before;
  const auto note = keep_updates_of_position(log);
  ASSERT_TRUE(note);
  EXPECT_EQ(*note,
            "the position changes only every 4 samples: only the rows in which it is new are used (250 Hz)");
  EXPECT_EQ(log.sample_rate_Hz, 250.0);
  EXPECT_EQ(log.start_time_s, 0.002);
  ASSERT_EQ(log.position_m.size(), 2000u);
  ASSERT_EQ(log.force_N.size(), 2000u);
  EXPECT_TRUE(log.velocity_mps.empty());
  for (std::size_t i = 0; i < log.position_m.size(); ++i) {
    EXPECT_EQ(log.position_m[i], before.position_m[4 * i + 2]);
    EXPECT_EQ(log.force_N[i], before.force_N[4 * i + 2]);
  }
}

TEST(HeldPosition, OtherLogsAreNotChanged) {
  Log log = log_with_position_held(1, 0);
  EXPECT_FALSE(keep_updates_of_position(log));
  EXPECT_EQ(log.position_m.size(), 8000u);
}

// At a constant velocity a coarse encoder changes every few samples too, by one step.
TEST(HeldPosition, ACoarseEncoderIsNotHeld) {
  std::vector<double> position_m;
  for (std::size_t i = 0; i < 8000; ++i)
    position_m.push_back(kStep_m * std::floor(0.25 * static_cast<double>(i)));
  EXPECT_EQ(updates_of_position(position_m).period, 1u);
}

// One sample in ten comes late: no row is known to be new.
TEST(HeldPosition, AnUnevenRateIsNotHeld) {
  std::vector<double> position_m(1, 0.0);
  test::Draw draw(10);
  std::size_t next = 4;
  for (std::size_t i = 1; i < 8000; ++i) {
    const bool is_new = i == next;
    if (is_new) next += draw.uniform(0.0, 1.0) < 0.1 ? 5 : 4;
    position_m.push_back(is_new ? 1e-4 * std::sin(1e-3 * static_cast<double>(i)) : position_m.back());
  }
  EXPECT_EQ(updates_of_position(position_m).period, 1u);
}

}  // namespace
}  // namespace slipstack::workbench
