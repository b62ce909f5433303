// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/alternatives/structure.h"

namespace slipstack::workbench {

/// A force at one short stretch of the rail: a damaged ball track, a dent, a cable that snags. It may depend
/// on the place alone (a dent) or change its sign with the motion (dirt that brakes). Searched where the
/// residual is loudest per pass; every other pass judged by the rest, so that what happened there only once
/// says nothing; or where the energy of all passes at speed is, whatever its form. All vectors at the rows.
/// Reduction 0 where no place is passed three times.
Structure place_on_rail(const Eigen::VectorXd& position_m, const Eigen::VectorXd& velocity_mps,
                        const Eigen::VectorXd& residual_N);

}  // namespace slipstack::workbench
