// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/search/forward_selection.h"

namespace slipstack::workbench {

/// Sets the steps of `diagnosis`, from the baseline to `best` one effect at a time, and its model with the
/// first effect. First the effect that is strongest alone (the candidates are ranked), then the one that
/// lowers the error most beside those before it. Each step's shapes are those of `best`, refined without what
/// comes later; the first takes its candidate's where these are closer to the training data.
void list_steps(const SelectionContext& context, const Explanation& best, Diagnosis& diagnosis);

/// Drops steps, from the last on, by which the held-out error does not fall significantly.
void drop_insignificant_steps(const Measurement& measurement, Diagnosis& diagnosis);

}  // namespace slipstack::workbench
