// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fitted_model.h"
#include "workbench/estimate/nonlinear/nominal_shapes.h"
#include "workbench/estimate/nonlinear/trial.h"

namespace slipstack::workbench {

/// Fits a model of these effects: shapes searched, gains fitted. The mass is the log's where it gives one.
FittedModel fit_effects(const Measurement& measurement, const std::vector<std::string>& effects,
                        const SearchEffort& effort);

/// Improves the shapes of every searched term of a fitted model in turn, others held; then fits all gains.
FittedModel refine_shapes_in_turn(const Measurement& measurement, FittedModel fitted,
                                  const SearchEffort& effort);

/// Searches the shapes of these effects of a fitted model from everywhere, the others' as they are: what was
/// found while another effect was missing may lie in another valley.
FittedModel search_globally(const Measurement& measurement, FittedModel fitted,
                            const std::vector<std::string>& effects);

}  // namespace slipstack::workbench
