// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/nonlinear/nominal_shapes.h"
#include "workbench/estimate/nonlinear/tangent.h"
#include "workbench/estimate/nonlinear/trial.h"

// The estimation of a non-linear model, each step built on those before it:
//   terms/search_ranges.h  which shapes are searched, and within which range
//   starting_shapes.h      the points from which a search starts
//   minimise.h             the search from one of them
//   fit_gains.h            all gains at given shapes: bounded least squares
//   trial.h                one more effect: its shapes searched, all gains fitted
//   nominal_shapes.h       shapes that leave their nominal value at the end
//   tangent.h              a Gauss-Newton step of all gains and shapes together
//   fit.h                  a whole model
namespace slipstack::workbench {

/// Fits a model of these effects: shapes searched, gains fitted. The mass is the log's where it declares one.
FittedModel fit_effects(const Measurement& measurement, const std::vector<std::string>& effects,
                        const SearchEffort& effort);

/// Refines the shapes of every searched term of a fitted model in turn, those of the others held; then fits
/// all gains.
FittedModel refine_shapes_in_turn(const Measurement& measurement, FittedModel fitted,
                                  const SearchEffort& effort);

/// Searches the shapes of these effects of a fitted model over their whole ranges, those of the others held.
/// Shapes that were found while another effect was missing may belong to another local minimum.
FittedModel search_globally(const Measurement& measurement, FittedModel fitted,
                            const std::vector<std::string>& effects);

}  // namespace slipstack::workbench
