// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fit_gains.h"

namespace slipstack::workbench {

/// The model with its hysteresis reduced to `elements` stop operators, all gains fitted again. Neighbours are
/// merged so that the level is preserved and the virgin curve changes least. Slip distances are whole encoder
/// steps, at least one, since the target counts steps. The cost of the reduction is the difference between
/// the held-out errors of the two models.
FittedModel reduce_hysteresis(const Measurement& measurement, const FittedModel& fitted,
                              std::size_t elements);

}  // namespace slipstack::workbench
