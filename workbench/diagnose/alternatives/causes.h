// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "workbench/diagnose/alternatives/cause_forms.h"
#include "workbench/diagnose/alternatives/structure.h"
#include "workbench/estimate/nonlinear/fitted_model.h"
#include "workbench/estimate/nonlinear/trial.h"

namespace slipstack::workbench {

/// The frequency, time, or place and width at which a cause outside the catalogue explains most of the
/// residual of `model`; empty where there is none. All of them are compared at the rows. Cost: O(rows log
/// rows), of a line rows x frequencies within one bin of a spectrum. What has a shape of another kind
/// (is_fitted_jointly()) is fitted jointly with the model, from the shapes `near` if there are any, with
/// `effort`: as many evaluations of a basis. Implemented in cause_shapes.cpp.
std::optional<std::vector<double>> shapes_of_cause(const Measurement& measurement, const FittedModel& model,
                                                   const EffectDescription& cause,
                                                   const std::vector<double>* near = nullptr,
                                                   const SearchEffort& effort = kFirstLook);

/// The model with the shapes of its causes found again, where that lowers the error: they were found while
/// other effects were in the model. Implemented in cause_shapes.cpp.
FittedModel with_causes_found_again(const Measurement& measurement, FittedModel model);

/// What a fitted cause says, in a model that contains it. `without_N`: the held-out error of the model
/// without it.
Structure described_cause(const Measurement& measurement, const FittedModel& model, const Term& cause,
                          double without_N);

/// Sorts the causes of one model as they are told: first forces that explain most of what the model leaves
/// without them, for which the form of the friction is only the background; then by what they explain. The
/// first then says all of them that the log determines, and the held-out error of the model. `beside`: the
/// effects of the model that are told nowhere else.
void tell_together(std::vector<Structure>& causes, const std::vector<std::string>& beside, double holdout_N);

}  // namespace slipstack::workbench
