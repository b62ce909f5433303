// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

// Confounders of the effects that were named: what is outside the catalogue and produces a similar force.
// Each function returns what the force is attributed to instead.

/// A free curve over one coordinate that explains far more of the baseline's residual than all effects that
/// were named.
std::optional<Structure> curve_behind_all(const Measurement& measurement, const Diagnosis& diagnosis);

/// A wrong unit of mass, time, position or force, which a payload would compensate for in the model.
std::optional<Structure> mass_of_another_axis(const Measurement& measurement, const Diagnosis& diagnosis);

}  // namespace slipstack::workbench
