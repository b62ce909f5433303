// SPDX-License-Identifier: Apache-2.0
// The bound of the comparison: the friction of the simulated axis, fed forward.
#include "workbench/loop/comparison/known_friction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim_host/log/draw.h"
#include "sim_host/plant/friction/maxwell_elements.h"
#include "workbench/base/statistics.h"
#include "workbench/loop/comparison/contenders.h"
#include "workbench/loop/comparison/measures.h"
#include "workbench/loop/comparison/workshop.h"

namespace slipstack::workbench {
namespace {

// Held over a tick, it is the mean of the forces at its ends where the friction is smooth, and never more
// than the saturation.
TEST(KnownFriction, IsTheMeanOverATickOfTheAxisesOwn) {
  const sim::Axis axis = sim::draw_bench(sim::Setup::kPickAndPlace, 11).axis;
  const Trajectory motion = judged_motion(axis, kComparedTick_s, true);
  const std::vector<double> force_N = known_friction_N(axis, motion);
  ASSERT_EQ(force_N.size(), motion.size());
  auto friction = sim::MaxwellElements::sample(axis.curve, axis.elements);
  friction.reset(motion.points.front().x_m);
  double worst_N = 0.0;
  double most_N = 0.0;
  for (std::size_t i = 0; i + 1 < motion.size(); ++i) {
    const double before_N = friction.force_N();
    if (motion.points[i + 1].x_m != motion.points[i].x_m) friction.move_to(motion.points[i + 1].x_m);
    worst_N = std::max(worst_N, std::fabs(force_N[i] - 0.5 * (before_N + friction.force_N())));
    most_N = std::max(most_N, std::fabs(force_N[i]));
  }
  EXPECT_LT(worst_N, 2e-3 * axis.curve.saturation_N());
  EXPECT_LE(most_N, axis.curve.saturation_N());
  EXPECT_GT(most_N, 0.99 * axis.curve.saturation_N());
}

// Without noise and with a fine encoder nothing is left that a compensator could take away: a model that is
// late by half a tick, or that moves the friction elsewhere, would leave more.
TEST(KnownFriction, LeavesNothingWithoutNoiseAndEncoderSteps) {
  const sim::Axis axis = sim::draw_bench(sim::Setup::kPickAndPlace, 11).axis;
  const Workshop workshop(axis, 11);
  const Trajectory motion = judged_motion(axis, kComparedTick_s, true);
  const ContenderName name{"bound", "bound", "", ContenderName::Kind::kBound};
  const auto reversal_m = [&](double noise_share, double encoder_share) {
    const DriveRun found = run(workshop.bound(name, noise_share, encoder_share), axis, motion, 11);
    EXPECT_FALSE(found.lost);
    return reversal_error(found.error_m, motion).rms_m;
  };
  const double bound_m = reversal_m(1.0, 1.0);
  EXPECT_LT(reversal_m(0.0, 1e-3), 0.02 * bound_m);
  EXPECT_LT(reversal_m(0.0, 1.0), bound_m);
  EXPECT_LT(reversal_m(1.0, 1e-3), bound_m);
  const Contender plain = workshop.plain({"mass", "", "", ContenderName::Kind::kPeer});
  EXPECT_LT(bound_m, 0.1 * reversal_error(run(plain, axis, motion, 11).error_m, motion).rms_m);
}

}  // namespace
}  // namespace slipstack::workbench
