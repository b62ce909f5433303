// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/known_friction.h"

#include <cstddef>
#include <utility>

#include "sim_host/plant/friction/maxwell_elements.h"

namespace slipstack::workbench {
namespace {

// In a tick; at a reversal within one the place of the reversal is right to a share of what is moved there.
constexpr int kParts = 4;

/// Between two ticks: the cubic with their positions and velocities (Hermite); u from 0 to 1.
double between(const sim::MotionPoint& from, const sim::MotionPoint& to, double tick_s, double u) {
  const double rest = 1.0 - u;
  const double ways_m = (from.v_mps * rest - to.v_mps * u) * tick_s;
  return rest * rest * (1.0 + 2.0 * u) * from.x_m + u * u * (1.0 + 2.0 * rest) * to.x_m + u * rest * ways_m;
}

}  // namespace

std::vector<double> known_friction_N(const sim::Axis& axis, const Trajectory& trajectory) {
  auto friction = sim::MaxwellElements::sample(axis.curve, axis.elements);
  friction.reset(trajectory.points.front().x_m);
  std::vector<double> force_N(trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const sim::MotionPoint& from = trajectory.points[i];
    const sim::MotionPoint& to = trajectory.points[i + 1 < trajectory.size() ? i + 1 : i];
    double sum_N = 0.5 * friction.force_N();
    for (int part = 1; part <= kParts; ++part) {
      const double x_m = between(from, to, trajectory.tick_s, static_cast<double>(part) / kParts);
      if (x_m != friction.position_m()) friction.move_to(x_m);
      sum_N += (part < kParts ? 1.0 : 0.5) * friction.force_N();
    }
    force_N[i] = sum_N / kParts;
  }
  return force_N;
}

}  // namespace slipstack::workbench
