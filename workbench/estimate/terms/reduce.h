// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// The model with its hysteresis reduced to `elements` stop operators, all gains fitted again. Neighbours are
/// merged so that the level stays and the virgin curve moves least; slip distances are whole encoder steps,
/// at least one, since the target counts steps. `fitted.holdout_rmse_N` against the reduced one's is
/// what the reduction costs.
FittedModel reduce_hysteresis(const Measurement& measurement, const FittedModel& fitted,
                              std::size_t elements);

}  // namespace slipstack::workbench
