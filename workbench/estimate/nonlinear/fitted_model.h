// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "workbench/estimate/linear/linearisation.h"
#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// Errors of a model on one whole log among several.
struct LogErrors {
  double rmse_N = 0.0;          ///< weighted
  double holdout_rmse_N = 0.0;  ///< on blocks held out of the fit; zero where nothing was fitted
  double relative_error = 0.0;
};

/// A model fitted to a measurement, with what is needed to judge it and to try further effects on it.
struct FittedModel {
  Terms terms;
  std::shared_ptr<const Linearisation> linearisation;
  std::shared_ptr<const NormalEquations> equations;
  NormalEquations::Constraints constraints;
  BoundedSolution solution;
  bool converged = true;  ///< the linearisation at these gains promises no lower error
  double train_rmse_N = 0.0;
  double holdout_rmse_N = 0.0;  ///< by blocked cross-validation
  double forward_rmse_N = 0.0;  ///< of the last third by a fit to the first two; zero: not computed
  /// The same of what of it lies within the travel of the first two: beyond it a map only guesses.
  double forward_within_travel_N = 0.0;
  /// Of the last third where its blocks are held out one fold at a time, as in `holdout_rmse_N`.
  double last_third_holdout_rmse_N = 0.0;
  double relative_error = 0.0;              ///< |residual| / |measured force|, both at the rows
  std::vector<double> block_squared_error;  ///< of each block when it is held out
  std::vector<double> block_weight;         ///< sum of the row weights of each block
  std::vector<LogErrors> log_errors;        ///< by log, where the measurement is an excerpt of the logs
};

}  // namespace slipstack::workbench
