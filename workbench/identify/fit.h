// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "workbench/identify/linearisation.h"
#include "workbench/identify/normal_equations.h"
#include "workbench/identify/terms.h"

namespace slipstack::workbench {

/// What a model leaves of one whole log among several.
struct LogErrors {
  double rmse_N = 0.0;  ///< weighted
  double holdout_rmse_N =
      0.0;  ///< the same on blocks that the fit has not seen; zero where nothing was fitted
  double relative_error = 0.0;
};

/// A model fitted to a measurement, with what is needed to judge it and to try further effects on it.
struct FittedModel {
  Terms terms;
  std::shared_ptr<const Linearisation> linearisation;
  std::shared_ptr<const NormalEquations> equations;
  NormalEquations::Constraints constraints;
  BoundedSolution solution;
  double train_rmse_N = 0.0;
  double holdout_rmse_N = 0.0;
  double relative_error = 0.0;              ///< |residual| / |measured force|, both at the rows
  std::vector<double> block_squared_error;  ///< held-out, by block
  std::vector<double> block_weight;         ///< of the rows of each block
  std::vector<LogErrors> log_errors;        ///< by log, where the measurement is an excerpt of the logs
};

/// How much work a shape search may spend.
struct SearchEffort {
  int evaluations = 40;  ///< of the refinement, for each searched effect
};

/// Fits all gains of `terms` with shapes as they are: bounded least squares, repeated where effects multiply.
/// `known`, a model of some of the same effects, saves building their columns again.
FittedModel fit_gains(const Measurement& measurement, Terms terms, const FittedModel* known = nullptr);

/// An effect added to a fitted model: best shapes, gains to first order, and the held-out error.
struct Trial {
  Term term;    ///< the effect
  Terms terms;  ///< the whole model, the effect last
  double holdout_rmse_N = 0.0;
  std::vector<double> block_squared_error;
};

/// Tries `effect` on top of `base`: searches its shapes (starting points, then refinement) for the lowest
/// held-out error of base and effect fitted jointly. With `start`, searches only from those shapes.
Trial try_effect(const Measurement& measurement, const FittedModel& base, const EffectDescription& effect,
                 const SearchEffort& effort, const std::vector<double>* start = nullptr);

/// Fits a model of these effects: shapes searched, gains fitted. `given` holds terms with values to keep as a
/// start. The mass is the log's where it gives one.
FittedModel fit_effects(const Measurement& measurement, const std::vector<std::string>& effects,
                        const SearchEffort& effort);

/// Improves the shapes of every searched term of a fitted model in turn, others held; then fits all gains.
FittedModel polish_shapes(const Measurement& measurement, FittedModel fitted, const SearchEffort& effort);

/// The model with shapes that have a customary value where held-out data want them, once it is known which
/// effects there are: viscous friction beside quadratic drag looks like a drag of lower exponent. Beside a
/// viscous friction the exponent of a drag is therefore not lowered.
FittedModel settle_customary_shapes(const Measurement& measurement, FittedModel fitted);
/// The same for `time_delay` alone: a low pass beside the delay, where there is one.
FittedModel settle_lag(const Measurement& measurement, FittedModel fitted);

/// Searches the shapes of these effects of a fitted model from everywhere, the others' as they are: what was
/// found while another effect was missing may lie in another valley.
FittedModel search_anew(const Measurement& measurement, FittedModel fitted,
                        const std::vector<std::string>& effects);

/// A term for `effect` as this log wants it: the inertia is given where the log declares a mass.
Term term_for_log(const Measurement& measurement, const EffectDescription& effect);
/// Sets the gain of the inertia to the mass that each log declares, where they declare one.
void give_mass(const Measurement& measurement, Term& inertia);

}  // namespace slipstack::workbench
