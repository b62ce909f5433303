// SPDX-License-Identifier: Apache-2.0
// Whether the axis hunts at rest, over over-compensation, delay, resolution, feedback; and what the
// compensation has to do with it where it does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/bench/observer/observed_axis.h"

namespace slipstack::observer {
namespace {

struct Hold {
  int swings = 0;          ///< of more than two counts and 0.1 um
  double between_m = 0.0;  ///< the extremes
};

// Turning points that lie a swing apart; a decaying settling has ended before the watch begins.
Hold hold_after(ObservedAxis& axis, double way_m) {
  axis.move(way_m, [](double) {});
  axis.watch(0.7, [](double) {});
  const double swing_m = std::max(2.0 * axis.axis().encoder_resolution_m, 1e-7);
  double lowest_m = axis.loop().plant.position_m(), highest_m = lowest_m, turned_m = lowest_m;
  int direction = 0;
  Hold hold;
  axis.watch(0.5, [&](double) {
    const double now_m = axis.loop().plant.position_m();
    lowest_m = std::min(lowest_m, now_m);
    highest_m = std::max(highest_m, now_m);
    const double moved_m = now_m - turned_m;
    if (direction * moved_m > 0.0) {
      turned_m = now_m;
    } else if (std::fabs(moved_m) > swing_m) {
      direction = moved_m > 0.0 ? 1 : -1;
      turned_m = now_m;
      ++hold.swings;
    }
  });
  hold.between_m = highest_m - lowest_m;
  return hold;
}

struct Grid {
  std::vector<std::uint64_t> seeds;
  std::vector<std::size_t> late_ticks;
  std::vector<double> level_errors;
  std::vector<double> ways_m;
  std::vector<float> gains;  ///< of position, velocity and integral, times those of the axis
  std::vector<float> disturbance_shares;
};
constexpr int kSustained = 4;  // swings in half a second

// Of all of the grid, how many hunt; `runs`: how many there were.
int hunting(const Grid& grid, int& runs) {
  int found = 0;
  const auto run = [&](const Setting& setting, double way_m) {
    ObservedAxis axis(setting);
    found += hold_after(axis, way_m).swings >= kSustained ? 1 : 0;
    axis.expect_enabled();
    ++runs;
  };
  for (const double resolution_m : {1e-9, 1e-8, 1e-7, 1e-6, 5e-6})
    for (const std::uint64_t seed : grid.seeds)
      for (const std::size_t late : grid.late_ticks)
        for (const double level_error : grid.level_errors)
          for (const float gain : grid.gains)
            for (const float share : grid.disturbance_shares)
              for (const bool observe : {false, true})
                for (const double way_m : grid.ways_m)
                  run({seed, level_error, 0.01, resolution_m, late,
                       [=](AxisParameters& p) {
                         p.observe_friction = observe;
                         p.disturbance_share = share;
                         p.position_gain_per_s *= gain;
                         p.velocity_gain_N_s_per_m *= gain;
                         p.integral_per_s *= gain;
                       }},
                      way_m);
  return found;
}

TEST(LimitCycles, NoneAtRestWithTooMuchCompensation) {
  int runs = 0;
  EXPECT_EQ(hunting({{1}, {0, 3}, {0.0, 0.1}, {1e-3, 2e-5}, {1.0F}, {0.0F, 1.0F}}, runs), 0);
  EXPECT_EQ(runs, 160);
}

// The wide one, on demand.
TEST(LimitCyclesWide, NoneAtRestWithTooMuchCompensation) {
  int runs = 0;
  const int found = hunting(
      {{1, 2}, {0, 1, 2, 3}, {-0.1, 0.0, 0.05, 0.1}, {1e-3, 1e-4, 2e-5}, {1.0F, 2.0F}, {0.0F, 1.0F}}, runs);
  EXPECT_EQ(found, 0);
  EXPECT_EQ(runs, 3840);
}

// A feedback that hunts, ten times too stiff and seven ticks late, hunts by as much without compensation:
// there is nothing that less of it could end.
TEST(LimitCycles, AreThoseOfTheFeedbackWhateverTheCompensation) {
  std::vector<double> between_m;
  for (const bool compensate : {true, false}) {
    Setting setting;
    setting.level_error = 0.1;
    setting.late_ticks = 7;
    setting.drive = [compensate](AxisParameters& p) {
      p.compensate = compensate;
      make_ten_times_stiffer(p);
    };
    ObservedAxis axis(setting);
    const Hold hold = hold_after(axis, 1e-3);
    EXPECT_GE(hold.swings, 20 * kSustained) << "the search sees it";
    between_m.push_back(hold.between_m);
  }
  EXPECT_GT(between_m[0], 2e-5);
  EXPECT_NEAR(between_m[0], between_m[1], 0.05 * between_m[1]);
}

}  // namespace
}  // namespace slipstack::observer
