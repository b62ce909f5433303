// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

// Confounders of the effects that were named: what is outside the catalogue and produces a similar force.
// Each function returns what the force is attributed to instead, or whether `diagnosis.unexplained` is it.

/// A free curve over one coordinate that explains far more of the baseline's residual than all effects that
/// were named.
std::optional<Structure> curve_behind_all(const Measurement& measurement, const Diagnosis& diagnosis);

/// A wrong unit of mass, time, position or force, which a payload would compensate for in the model.
std::optional<Structure> mass_of_another_axis(const Measurement& measurement, const Diagnosis& diagnosis);

/// Whether a line above the bandwidth of the rows is the likely cause of what was named: it is stronger than
/// all of the baseline's error within the band. The response of a controller, quantisation and sampling bring
/// part of such a line into the band.
bool line_masks_effects(const Measurement& measurement, const Diagnosis& diagnosis);

/// Whether Coulomb friction that was named beside hysteresis is backlash: both change the force after each
/// reversal. Coulomb friction leaves nothing there; backlash also causes impacts, which remain in the
/// residual after reversals.
bool backlash_as_coulomb(const Diagnosis& diagnosis);

}  // namespace slipstack::workbench
