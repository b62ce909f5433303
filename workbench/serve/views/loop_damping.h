// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "workbench/report/pictures.h"

namespace slipstack::workbench {

/// Equivalent damping ratio at resonance of closed hysteresis loops, ζᵣ = E/(2π·A·F) ([2], section 3.2), of
/// loops of about one amplitude A.
struct LoopDamping {
  double amplitude_m = 0.0;       ///< mean
  std::vector<double> ratio;      ///< mean of each force that was given
  std::vector<double> deviation;  ///< standard deviation over the loops, likewise; zero of a single loop
  std::size_t loops = 0;
};

/// Finds the loops in the motion: from one reversal to the next but one, where that ends within 5 % of the
/// height from where it began, up to an amplitude of 0.2 mm. `forces_N`: at the rows, without the force of
/// inertia, which would add to the force at the tips. Loops that any of them passes in the wrong sense are
/// left out; amplitudes within 10 % belong together. Ascending amplitudes; empty where there is no loop.
std::vector<LoopDamping> loop_damping(const Measurement& measurement,
                                      const std::vector<Eigen::VectorXd>& forces_N);

/// Adds `damping` of one or two models, where there are loops: {amplitude_m, measured, deviation, model,
/// after, loops}. `inertia_N`: force of the moving mass at the rows.
void add_loop_damping(nlohmann::json& data, const Measurement& measurement, const Eigen::VectorXd& inertia_N,
                      const ForceRows& before, const ForceRows* after);

}  // namespace slipstack::workbench
