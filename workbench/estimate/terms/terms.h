// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// A term with the catalogue's bounds, zero gains and shapes that suit the log: slip distances from below the
/// encoder's step to the largest travel, maps over the stroke, the middle of the range for the rest.
Term make_term(const Measurement& measurement, const EffectDescription& effect);

/// Bounds of all gains, and the penalty that says what is known before the data: maps are smooth and
/// modulations below one. `error_N`, what the model leaves, scales it against the data.
NormalEquations::Constraints constraints_of(const Terms& terms, double error_N);

/// `term` with as many sets of gains as this measurement wants of it, each a copy of the first.
Term with_gain_sets(const Measurement& measurement, Term term);
/// Terms with one set of gains each, for a controller that does not know what it will carry: the mean over
/// the logs, each as long as it is.
Terms averaged_over_logs(const Measurement& measurement, Terms terms);

}  // namespace slipstack::workbench
