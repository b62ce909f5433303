// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

/// Sets the verdict and `unexplained`: searches the residual of the explanation for structure, and tests
/// whether a confounder is a better explanation than the effects that were named. Needs the steps, the
/// explained model and the noise floor of `diagnosis`.
void judge(const Measurement& measurement, Diagnosis& diagnosis);

/// Sets the refusal of the candidate of lowest error among those that the log supports, by a share that is
/// worth a name, and that are no steps: of what is plausible, that it is too small. Cost: a fit of its gains.
void note_refusal(const Measurement& measurement, Diagnosis& diagnosis);

}  // namespace slipstack::workbench
