// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/alternatives/structure.h"

namespace slipstack::workbench {

/// Passes that make a place: fewer are events in time.
inline constexpr int kFewestPasses = 4;

/// How often the axis came within `half_width_m` of `middle_m`.
int passes_of_place(const Eigen::VectorXd& position_m, double middle_m, double half_width_m);

/// A force at one short section of the rail: a damaged ball track, a dent, a cable that snags. It may depend
/// on the place alone (a dent) or change its sign with the motion (dirt that brakes). It is searched where
/// the energy of the residual is largest, as a curve over the place, of which every other pass is predicted
/// by the rest, so that a single occurrence explains nothing. All vectors at the rows. The reduction is 0
/// where no place is passed kFewestPasses times.
Structure place_on_rail(const Eigen::VectorXd& position_m, const Eigen::VectorXd& velocity_mps,
                        const Eigen::VectorXd& residual_N);

}  // namespace slipstack::workbench
