// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// Whether the term has a gain below zero that hardly any axis has so (Plausibility::seldom_negative), and it
/// has not so alone, or it does not explain most of what is left without it but with a mass of the log's own.
bool is_doubtfully_negative(const Measurement& measurement, const FittedModel& baseline,
                            const FittedModel& model, const Term& term);

/// The model with gains that hardly any axis has below zero (Plausibility::seldom_negative) at zero at least,
/// unless the log leaves no doubt: such a gain is negative alone too, and explains most of what is left with
/// it at zero and a mass of the log's own.
FittedModel without_doubtful_negatives(const Measurement& measurement, const FittedModel& baseline,
                                       FittedModel model);

}  // namespace slipstack::workbench
