// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "workbench/diagnose/alternatives/structure.h"
#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

// Causes outside the catalogue that have a form: they are tried, fitted and compared as effects are, so that
// an effect is named only where none of them describes the force better. No controller can compensate them.
//
//   line_in_time       F = c cos(2 pi f t) + s sin(2 pi f t)
//   change_at_a_time   from the time t0 on, the dry friction times 1 + level, and another offset
//   force_at_a_place   F = (push + slope sin(pi u)) w, dry friction times 1 + level w,
//                      w = (1 + cos(pi u)) / 2 for |u| < 1, u = (x - x0) / half width
//   force_over_time    F = a linear spline of the time

/// Those that this measurement can show; time that several logs do not share is no coordinate.
std::vector<const EffectDescription*> causes_to_try(const Measurement& measurement);

bool is_outside_catalogue(const EffectDescription& effect);

/// The frequency, time, or place and width at which the cause explains most of the residual of `model`; empty
/// where there is none. All of them are compared at the rows. Cost: O(rows log rows), of a line rows x
/// frequencies within one bin of a spectrum.
std::optional<std::vector<double>> shapes_of_cause(const Measurement& measurement, const FittedModel& model,
                                                   const EffectDescription& cause);

/// The model with the shapes of its causes found again, where that lowers the error: they were found while
/// other effects were in the model.
FittedModel with_causes_found_again(const Measurement& measurement, FittedModel model);

/// What a fitted cause says, in a model that contains it. `without_N`: the held-out error of the model
/// without it.
Structure described_cause(const Measurement& measurement, const FittedModel& model, const Term& cause,
                          double without_N);

}  // namespace slipstack::workbench
