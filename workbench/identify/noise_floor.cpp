// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/noise_floor.h"

#include <cmath>

#include "workbench/identify/linearisation.h"

namespace slipstack::workbench {

double NoiseFloor::of(const Terms& terms) const {
  const Eigen::VectorXd here = measurement_.filtered(evaluate_force(measurement_, terms).force_N);
  const Eigen::VectorXd there = measurement_.filtered(evaluate_force(shifted_, terms).force_N);
  // The second reading takes the first's motion for the truth: their difference is one encoder's error.
  const double quantisation = (here - there).squaredNorm() / static_cast<double>(here.size());
  const double force = measurement_.filtered_force_noise_N();
  const double inertia = mass_kg(terms) * measurement_.acceleration_noise_mps2();
  return std::sqrt(force * force + inertia * inertia + quantisation);
}

}  // namespace slipstack::workbench
