// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/measures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_host/log/draw.h"
#include "workbench/loop/comparison/comparison.h"

namespace slipstack::workbench {
namespace {

TEST(Measures, SettlingIsTheLastTimeTheErrorIsBeyond) {
  Trajectory trajectory;
  trajectory.tick_s = 1e-3;
  const Trajectory::Move move{1e-3, 10, 20};
  std::vector<double> error(40, 0.0);
  EXPECT_EQ(settling_s(error, trajectory, move, 1e-6), 0.0);
  error[12] = 3e-6;
  error[17] = -1.5e-6;
  EXPECT_NEAR(settling_s(error, trajectory, move, 1e-6), 8e-3, 1e-12);
  EXPECT_NEAR(settling_s(error, trajectory, move, 2e-6), 3e-3, 1e-12);
  error[29] = 2e-6;  // the last tick of the dwell: it never settled
  EXPECT_NEAR(settling_s(error, trajectory, move, 1e-6), 20e-3, 1e-12);
  error[29] = 0.0;
  error[30] = 2e-6;  // the next move
  EXPECT_NEAR(settling_s(error, trajectory, move, 1e-6), 8e-3, 1e-12);
}

TEST(Measures, OnlyTheErrorAfterAReversalCountsAsOne) {
  Trajectory trajectory;
  trajectory.tick_s = 1e-3;
  trajectory.reversals = {100, 120, 300};  // the first two overlap
  std::vector<double> error(400, 0.0);
  error[99] = error[170] = error[299] = error[350] = 1.0;  // outside
  EXPECT_EQ(reversal_error(error, trajectory).peak_m, 0.0);
  error[100] = error[169] = error[349] = 2.0;  // inside
  const ReversalError found = reversal_error(error, trajectory);
  EXPECT_EQ(found.peak_m, 2.0);
  EXPECT_NEAR(found.rms_m, 2.0 * std::sqrt(3.0 / 120.0), 1e-12);
}

TEST(Measures, TheJudgedMotionIsConsistentAndWithinTheAxis) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    const sim::Axis axis = sim::draw_bench(sim::Setup::kRandom, seed).axis;
    std::vector<Trajectory> motions = {judged_motion(axis, 1e-4, false), judged_motion(axis, 1e-4, true)};
    for (const double r : {0.1e-3, 1e-3, 50e-3}) {
      motions.push_back(circle(axis, r, 1e-4, true));
      motions.push_back(circle(axis, r, 1e-4, false));
    }
    for (const Trajectory& motion : motions) {
      EXPECT_FALSE(motion.reversals.empty());
      EXPECT_EQ(motion.points.front().v_mps, 0.0);
      for (std::size_t i = 1; i + 1 < motion.size(); ++i) {
        const auto& [x, v, a] = motion.points[i];
        ASSERT_GT(x, 0.0);
        ASSERT_LT(x, axis.stroke_m);
        const double slope = (motion.points[i + 1].x_m - motion.points[i - 1].x_m) / 2e-4;
        ASSERT_NEAR(v, slope, 2e-4 * std::fabs(a) + 1e-5) << seed << ' ' << i;
        const double bend = (motion.points[i + 1].v_mps - motion.points[i - 1].v_mps) / 2e-4;
        ASSERT_NEAR(a, bend, 0.05 * std::fabs(a) + 0.1) << seed << ' ' << i;
      }
    }
  }
}

TEST(Measures, AMoveEndsWhereItsDwellBegins) {
  const sim::Axis axis = sim::draw_bench(sim::Setup::kPickAndPlace, 1).axis;
  const Trajectory motion = judged_motion(axis, 1e-4, false);
  ASSERT_EQ(motion.moves.size(), 8U);
  for (const Trajectory::Move& move : motion.moves) {
    EXPECT_NE(motion.points[move.end - 3].v_mps, 0.0);
    for (std::size_t i = move.end; i + 2 < std::min(move.end + move.dwells, motion.size()); ++i)
      ASSERT_NEAR(motion.points[i].v_mps, 0.0, 1e-9);
  }
}

TEST(Measures, ALevelScalesTheVirginCurve) {
  const sim::Axis axis = sim::draw_bench(sim::Setup::kRandom, 4).axis;
  const sim::Axis warm = with_level(axis, 0.8);
  for (const double x : {1e-7, 1e-6, 1e-5, 1e-3})
    EXPECT_NEAR(warm.curve.force_N(x), 0.8 * axis.curve.force_N(x), 1e-12 * axis.curve.force_N(x));
}

// Of made-up figures: who wins a cell is told, and what a goal compares.
TEST(Comparison, SaysWhereAnotherIsBetterAndWhichGoalsAreMet) {
  using Kind = ContenderName::Kind;
  const auto made = [](const std::string& id, Kind kind, double reversal, double settling) {
    ComparedContender one{{id, "the " + id, "a reason", kind}, {}};
    for (const double factor : {1.0, 1.1, 0.9}) {
      Measures measures;
      measures.fill(factor);
      measures[static_cast<std::size_t>(Measure::kReversalPeak)] = factor * reversal;
      measures[static_cast<std::size_t>(Measure::kSettle100mm)] = factor * settling;
      one.by_seed.push_back(measures);
    }
    return one;
  };
  Comparison comparison;
  comparison.seeds = 3;
  comparison.contenders = {
      made("p_pi", Kind::kPeer, 20.0, 9.0),          made("mass", Kind::kPeer, 10.0, 8.0),
      made("velocity-table", Kind::kPeer, 4.0, 6.0), made("ilc", Kind::kLearner, 0.5, 5.0),
      made("maxwell_slip", Kind::kOurs, 0.9, 4.0),   made("bound", Kind::kBound, 0.4, 3.0)};
  const std::vector<ComparedGoal> goals = goals_of(comparison);
  ASSERT_EQ(goals.size(), 4U);
  EXPECT_TRUE(goals[0].met) << goals[0].found;
  EXPECT_TRUE(goals[1].met) << goals[1].found;  // the learning one does not count
  EXPECT_TRUE(goals[2].met) << goals[2].found;
  EXPECT_TRUE(goals[3].met) << goals[3].found;  // equal is not worse
  const std::vector<std::string> lost = lost_cells(comparison);
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_NE(lost[0].find("the ilc wins"), std::string::npos) << lost[0];
  comparison.contenders[4].by_seed[1][static_cast<std::size_t>(Measure::kWrong)] = 1.2;
  comparison.contenders[1] = made("mass", Kind::kPeer, 8.0, 8.0);
  EXPECT_FALSE(goals_of(comparison)[0].met);
  EXPECT_EQ(goals_of(comparison)[0].found, "0.11 of the mass; with the friction known 0.05");
  comparison.contenders.back() = made("bound", Kind::kBound, 0.85, 3.0);
  EXPECT_EQ(goals_of(comparison)[0].found,
            "0.11 of the mass; with the friction known 0.11, so that no friction model reaches it");
  EXPECT_FALSE(goals_of(comparison)[3].met);
}

}  // namespace
}  // namespace slipstack::workbench
