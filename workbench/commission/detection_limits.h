// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

// What the logs of a commissioning would not have shown, beside what `explained` has: both need motions that
// change fast, which an axis that nobody knows is not asked for. A sentence each; empty where the model has
// it. By detection_limit(), at the cost of the columns of one and of three effects.

/// The smallest delay between force and motion that would have been named.
std::string delay_limit_text(const Measurement& measurement, const FittedModel& explained);
/// The smallest structural resonance, at three frequencies, and the frequency above which none.
std::string mode_limit_text(const Measurement& measurement, const FittedModel& explained);

}  // namespace slipstack::workbench
