// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// Whether the term has a stiffness below zero, and has not alone, or does not explain most of what is left
/// without it but with a mass of the log's own. A stiffness: a gain that hardly any axis has below zero
/// (Plausibility::seldom_negative), or the slope, in the middle of the travel, of a force that repeats after
/// a turn of which the log shows less than half.
bool is_doubtfully_negative(const Measurement& measurement, const FittedModel& baseline,
                            const FittedModel& model, const Term& term);

}  // namespace slipstack::workbench
