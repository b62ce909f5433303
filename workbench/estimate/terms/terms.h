// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// A term with the bounds of the catalogue, zero gains and shapes that suit the log: slip distances from
/// below the encoder's step to the largest travel, maps over the stroke, the middle of the range for all
/// others.
Term make_term(const Measurement& measurement, const EffectDescription& effect);
/// The same, with the inertia fixed to the declared mass where the log declares one.
Term term_for_log(const Measurement& measurement, const EffectDescription& effect);
/// Fixes the gain of the inertia to the mass that each log declares, where they declare one.
void set_declared_mass(const Measurement& measurement, Term& inertia);
/// Terms of a model file for this measurement: gain sets as it needs them, and the declared mass.
Terms terms_on(const Measurement& measurement, Terms terms);

/// Bounds of all gains, and the penalty that expresses the prior: maps are smooth, and modulations are below
/// one. `error_N`, the residual error of the model, scales it against the data.
NormalEquations::Constraints constraints_of(const Terms& terms, double error_N);

/// `term` with as many sets of gains as this measurement needs, each a copy of the first.
Term with_gain_sets(const Measurement& measurement, Term term);
/// Terms with one set of gains each, for a controller that does not know its payload: the mean over the logs,
/// weighted by their lengths.
Terms averaged_over_logs(const Measurement& measurement, Terms terms);

}  // namespace slipstack::workbench
