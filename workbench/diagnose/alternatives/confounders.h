// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/diagnose.h"

namespace slipstack::workbench {

// What was named may stand in for something that no effect of the catalogue is. Each of these says what it is
// then, or that it is so of what `diagnosis.unexplained` holds.

/// A free curve over one coordinate, or one place of the rail, that explains far more of the baseline's
/// residual than all effects that were named.
std::optional<Structure> curve_behind_all(const Measurement& measurement, const Diagnosis& diagnosis);

/// The line in time that was named as a resonance: moves excite a mode anew each time, in whatever phase, but
/// what keeps its phase from the first move to the last is no ringing. Within a control loop the axis moves
/// at the line's frequency, and a mode that hardly decays makes the line of that motion.
std::optional<Structure> line_as_resonance(const Measurement& measurement, const Diagnosis& diagnosis);

/// A mass in the wrong unit, or time, position or force: the payload that would make up for it is no answer.
std::optional<Structure> mass_of_another_axis(const Measurement& measurement, const Diagnosis& diagnosis);

/// Whether a line in time is what is left, most of it or at the very frequency of the resonance that was
/// named: a controller answers a line with motion at its frequency, and a mode that hardly decays poses as
/// the cause.
bool line_causes_mode(const Diagnosis& diagnosis);

/// Whether a line above the rows' band drowns what was named: it is far stronger than all that the baseline
/// left within the band, hardly above a noise floor that the line itself raises. A controller answers it, and
/// quantisation and sampling fold it back.
bool line_masks_effects(const Measurement& measurement, const Diagnosis& diagnosis);

/// Whether Coulomb friction that was named beside hysteresis is play: both make a force after each reversal.
/// Coulomb friction explains the whole of its own, play knocks as well, and that comes after reversals too.
bool backlash_as_coulomb(const Diagnosis& diagnosis);

}  // namespace slipstack::workbench
