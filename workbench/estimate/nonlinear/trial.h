// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/nonlinear/minimise.h"
#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {

/// The effort of looks at many effects, of which the best are refined afterwards. The coarse tolerance moved
/// an error by a thousandth on EMPS, a thirtieth of what is worth a name (verdicts: docs/theory.md).
inline constexpr SearchEffort kFirstLook{40, 1e-4};

/// An effect added to a fitted model: best shapes, gains to first order, and the held-out error.
struct Trial {
  Term term;    ///< the effect
  Terms terms;  ///< the whole model, the effect last
  double holdout_rmse_N = 0.0;
  std::vector<double> block_squared_error;
  /// The log cannot show the effect, whatever the search found: it decays below the slowest visible speed, or
  /// is a map over a travel, or repeats within one, within which friction develops. The errors are those of
  /// the base.
  bool below_visible = false;
};

/// Tries `effect` on top of `base`: searches its shapes (starting points, then refinement) for the lowest
/// error of base and effect fitted jointly, by all rows. With `start`, searches only from those shapes.
Trial try_effect(const Measurement& measurement, const FittedModel& base, const EffectDescription& effect,
                 const SearchEffort& effort, const std::vector<double>* start = nullptr);

/// The shapes of `effect` within `ranges` for the lowest error of base and effect fitted jointly: the best of
/// `starts`, refined. For shapes that try_effect() does not search.
std::vector<double> jointly_best_shapes(const Measurement& measurement, const FittedModel& base,
                                        const EffectDescription& effect,
                                        const std::vector<std::vector<double>>& starts,
                                        const std::vector<ShapeRange>& ranges, const SearchEffort& effort);

/// Equations of a model with `term` added at its present shapes; `equations` are those of the model without
/// it.
NormalEquations equations_with(const Measurement& measurement, const Linearisation& linearisation,
                               const NormalEquations& equations, const Term& term);

}  // namespace slipstack::workbench
