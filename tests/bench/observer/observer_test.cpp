// SPDX-License-Identifier: Apache-2.0
// The friction observer on the measurement: what it gains, what it must not change, and the page about it.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bench/documented_table.h"
#include "tests/bench/observer/cases.h"

namespace slipstack::observer {
namespace {

// Where the axis creeps while the reference rests, a model that sees the reference alone begins the next move
// with the friction of the other direction.
TEST(FrictionObserver, PausesNoLongerSpoilTheNextMove) {
  const Drive alone = drives()[1], observed = drives()[2];
  const double without_um = moves_with_pause(alone, 0.03, 0.3).rms();
  const double with_um = moves_with_pause(observed, 0.03, 0.3).rms();
  EXPECT_GT(without_um, 20.0);
  EXPECT_LT(with_um, 0.25 * without_um);
  // Better than that would need an explanation: the level is 3 % wrong.
  EXPECT_GT(with_um, 0.5);
  // Without a pause there is nothing to observe.
  EXPECT_NEAR(moves_with_pause(observed, 0.03, 0.0).rms(), moves_with_pause(alone, 0.03, 0.0).rms(), 0.3);
}

TEST(FrictionObserver, IsNotWorseAtRestWhenPushedOrWithTheDisturbanceObserver) {
  for (const double level_error : {0.2, -0.3}) {
    for (const std::size_t first : {1U, 4U}) {
      const Visits alone = visit(drives()[first], level_error);
      const Visits observed = visit(drives()[first + 1], level_error);
      for (std::size_t i = 0; i < alone.moving.size(); ++i) {
        EXPECT_LT(observed.moving[i].rms(), 1.15 * alone.moving[i].rms() + 1.0) << level_error << ' ' << i;
        EXPECT_LT(observed.standing[i].rms(), 1.15 * alone.standing[i].rms() + 0.5)
            << level_error << ' ' << i;
      }
      EXPECT_LT(observed.left.rms(), 1.1 * alone.left.rms() + 0.2);
    }
  }
}

// The counts are a script, whatever the current is: what they do to the current is that of the linear
// feedback alone, to rounding, and the hysteresis has moved all the same.
TEST(FrictionObserver, ACorrectionLeavesTheForceAsItIs) {
  for (const float share : {0.0F, 0.4F, 1.0F}) {
    const auto scripted = [share](bool observe) {
      Setting setting;
      setting.drive = [&](AxisParameters& p) {
        p.observe_friction = observe;
        p.disturbance_share = share;
        p.following_error_m = 1e-2F;
        p.unseen_motion_m = 0.0F;
      };
      return ObservedAxis(setting);
    };
    ObservedAxis observed = scripted(true), blind = scripted(false);
    const std::int32_t home = blind.controller().reference().counts();
    double largest_N = 0.0, moved_N = 0.0;
    for (int tick = 0; tick < 2000; ++tick) {
      const std::int32_t counts =
          home +
          static_cast<std::int32_t>(std::lround(15.0 * std::sin(tick * 4e-3) + 6.0 * std::sin(tick * 0.11)));
      std::array<double, 2> force_N{};
      for (std::size_t i = 0; i < 2; ++i) {
        ObservedAxis& axis = i == 0 ? observed : blind;
        axis.loop().reads = [counts](std::int64_t) { return EncoderReading{.counts = counts}; };
        axis.step();
        force_N[i] =
            static_cast<double>(axis.controller().output().current_A) * axis.axis().motor_constant_N_per_A;
      }
      largest_N = std::max(largest_N, std::fabs(force_N[0] - force_N[1]));
      moved_N =
          std::max(moved_N, static_cast<double>(std::fabs(observed.controller().friction().dry_friction_N -
                                                          blind.controller().friction().dry_friction_N)));
    }
    EXPECT_LT(largest_N, 1e-3) << share;
    EXPECT_GT(moved_N, 5.0) << share;
  }
}

TEST(FrictionObserver, ACountThatFlickersMovesNothing) {
  Setting setting;
  setting.drive = [](AxisParameters& p) { p.unseen_motion_m = 0.0F; };
  ObservedAxis axis(setting);
  const std::int32_t home = axis.controller().reference().counts();
  int ticks = 0, width = 1;
  axis.loop().reads = [&](std::int64_t) {
    return EncoderReading{.counts = home + (++ticks % 3 == 0 ? width : 0)};
  };
  axis.watch(0.01, [](double) {});
  const auto range_N = [&axis] {
    float lowest_N = 1e9F, highest_N = -1e9F;
    axis.watch(0.5, [&](double) {
      lowest_N = std::min(lowest_N, axis.controller().friction().dry_friction_N);
      highest_N = std::max(highest_N, axis.controller().friction().dry_friction_N);
    });
    return highest_N - lowest_N;
  };
  EXPECT_EQ(range_N(), 0.0F);
  width = 4;
  axis.watch(0.01, [](double) {});
  EXPECT_GT(range_N(), 0.5F) << "that is more than the dead band";
}

TEST(FrictionObserver, AShareOfTheFrictionMakesTheAxisLightInTorqueMode) {
  const Led heavy = lead(0.0F, 0.03), light = lead(0.8F, 0.03);
  EXPECT_LT(light.hand_N.rms(), 0.5 * heavy.hand_N.rms());
  // What moves the mass remains.
  EXPECT_GT(light.hand_N.rms(), 0.2 * heavy.hand_N.rms());
  // Let go it stops, as long as the share of the model's friction is less than there is; else it does not.
  EXPECT_LT(light.coast_mps, 1e-3);
  EXPECT_LT(lead(0.5F, 0.45).coast_mps, 1e-3);
  EXPECT_GT(lead(1.0F, 0.2).coast_mps, 0.02);
}

// As the page says to make it: observer_test --table.
TEST(FrictionObserver, ThePageHasTheTableOfToday) {
  expect_page_has(SLIPSTACK_OBSERVER_PAGE, table());
}

}  // namespace
}  // namespace slipstack::observer

int main(int count, char** words) {
  return slipstack::print_table_or_run_tests(count, words, slipstack::observer::table);
}
