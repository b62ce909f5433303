// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

// Confounders of the effects that were named: what is outside the catalogue and produces a similar force.
// Each function returns what the force is attributed to instead, or whether `diagnosis.unexplained` is it.

/// A free curve over one coordinate, or a force at one place of the rail, that explains far more of the
/// baseline's residual than all effects that were named.
std::optional<Structure> curve_behind_all(const Measurement& measurement, const Diagnosis& diagnosis);

/// A spectral line that was named as a resonance. Each move excites a mode with another phase; a force that
/// keeps its phase from the first move to the last is not the ringing of a mode. Under control the axis moves
/// at the frequency of the line, and the model of a nearly undamped mode then reproduces the line from this
/// motion.
std::optional<Structure> line_as_resonance(const Measurement& measurement, const Diagnosis& diagnosis);

/// A wrong unit of mass, time, position or force, which a payload would compensate for in the model.
std::optional<Structure> mass_of_another_axis(const Measurement& measurement, const Diagnosis& diagnosis);

/// Whether the residual of the explanation is mostly a spectral line, or a line at the frequency of the
/// resonance that was named. A controller responds to a line with motion at its frequency, and a nearly
/// undamped mode then explains part of the line.
bool line_causes_mode(const Diagnosis& diagnosis);

/// Whether a line above the bandwidth of the rows is the likely cause of what was named: it is far stronger
/// than the baseline's error within the band, and this error is hardly above a noise floor that the line
/// itself raises. The response of a controller, quantisation and sampling bring part of such a line into the
/// band.
bool line_masks_effects(const Measurement& measurement, const Diagnosis& diagnosis);

/// Whether Coulomb friction that was named beside hysteresis is backlash: both change the force after each
/// reversal. Coulomb friction leaves nothing there; backlash also causes impacts, which remain in the
/// residual after reversals.
bool backlash_as_coulomb(const Diagnosis& diagnosis);

}  // namespace slipstack::workbench
