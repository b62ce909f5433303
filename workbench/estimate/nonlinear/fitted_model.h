// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "workbench/estimate/linear/linearisation.h"
#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// What a model leaves of one whole log among several.
struct LogErrors {
  double rmse_N = 0.0;          ///< weighted
  double holdout_rmse_N = 0.0;  ///< on blocks that the fit has not seen; zero where nothing was fitted
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

/// Fits all gains of `terms` with shapes as they are: bounded least squares, repeated where effects multiply.
/// `known`, a model of some of the same effects, saves building their columns again.
FittedModel fit_gains(const Measurement& measurement, Terms terms, const FittedModel* known = nullptr);

/// A model at its gains as they are: what trials need, without a fit. `error_N` is what it is known to leave.
FittedModel linearised(const Measurement& measurement, Terms terms, double error_N);

/// A term for `effect` as this log wants it: the inertia is given where the log declares a mass.
Term term_for_log(const Measurement& measurement, const EffectDescription& effect);
/// Sets the gain of the inertia to the mass that each log declares, where they declare one.
void set_declared_mass(const Measurement& measurement, Term& inertia);

/// Terms of a model file, for this log: its mass is the log's where the log declares one.
Terms terms_on(const Measurement& measurement, Terms terms);

}  // namespace slipstack::workbench
