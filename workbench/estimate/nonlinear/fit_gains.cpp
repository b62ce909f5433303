// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/fit_gains.h"

#include <algorithm>
#include <cmath>

namespace slipstack::workbench {
namespace {

constexpr int kGaussNewtonSteps = 4;  ///< at most; two or three suffice as a rule (linearisation.h)
constexpr double kConverged = 1e-4;   ///< relative change of the force that ends the Gauss-Newton steps

bool all_zero(const Term& term) {
  for (const double gain : term.gains) {
    if (gain != 0.0) return false;
  }
  return true;
}

bool dry_friction_known(const Terms& terms) {
  for (const Term& term : terms) {
    if (term.effect->acts_as(Acts::dry) && !all_zero(term)) return true;
  }
  return false;
}

/// Fits the gains without the effects that modulate others. Products of gains can then be linearised there;
/// at zero dry friction their derivatives would vanish.
void fit_without_products(const Measurement& measurement, Terms& terms, double noise_N) {
  Terms plain;
  for (const Term& term : terms) {
    if (!multiplies(term)) plain.push_back(term);
  }
  const Linearisation linearisation(measurement, plain);
  const NormalEquations equations(measurement, linearisation.columns(), linearisation.target());
  take_gains(plain, equations.fit(constraints_of(plain, noise_N)).value);
  for (Term& term : terms) {
    if (const Term* fitted = find_term(plain, term.effect->text.id)) term.gains = fitted->gains;
  }
}

/// Computes the errors of a fitted model, in sample and held out.
void judge(const Measurement& measurement, FittedModel& fitted) {
  const auto judged = fitted.equations->cross_validate(fitted.constraints, fitted.solution.bound_states);
  fitted.holdout_rmse_N = judged.rmse;
  fitted.block_squared_error = judged.block_squared_error;
  fitted.block_weight.resize(judged.block_squared_error.size());
  for (int block = 0; block < fitted.equations->block_count(); ++block) {
    fitted.block_weight[static_cast<std::size_t>(block)] = fitted.equations->weight(block);
  }
  const Eigen::VectorXd residual = fitted.linearisation->residual_N();
  fitted.train_rmse_N = measurement.weighted_rms(residual);
  const Eigen::VectorXd& usable = measurement.row_usable();
  fitted.relative_error = residual.cwiseProduct(usable).norm() /
                          std::max(fitted.linearisation->measured_N().cwiseProduct(usable).norm(), 1e-300);
}

}  // namespace

FittedModel fit_gains(const Measurement& measurement, Terms terms, const FittedModel* known) {
  const double noise_N = measurement.filtered_force_noise_N();
  const bool products = any_multiplies(terms);
  if (products && !dry_friction_known(terms)) fit_without_products(measurement, terms, noise_N);

  FittedModel fitted;
  double error_N = known == nullptr ? noise_N : known->train_rmse_N;
  std::shared_ptr<const Linearisation> linearisation;
  Eigen::VectorXd before = Eigen::VectorXd::Zero(measurement.row_count());
  for (int step = 0; step < kGaussNewtonSteps; ++step) {
    linearisation = std::make_shared<Linearisation>(measurement, terms,
                                                    known == nullptr ? nullptr : known->linearisation.get());
    fitted.equations =
        std::make_shared<NormalEquations>(measurement, linearisation->columns(), linearisation->target());
    fitted.constraints = constraints_of(terms, error_N);
    fitted.solution = fitted.equations->fit(fitted.constraints, fitted.solution.bound_states);
    error_N = std::sqrt(fitted.equations->squared_error(fitted.solution.value) / fitted.equations->weight());
    take_gains(terms, fitted.solution.value);
    if (!products) break;
    const Eigen::VectorXd now = linearisation->columns() * fitted.solution.value;
    const bool converged = (now - before).norm() <= kConverged * now.norm();
    before = now;
    if (converged) break;
  }
  // Linearised again at the final gains: residuals and trials start from here.
  fitted.linearisation = std::make_shared<Linearisation>(*linearisation, terms);
  fitted.terms = std::move(terms);
  judge(measurement, fitted);
  return fitted;
}

FittedModel linearised(const Measurement& measurement, Terms terms, double error_N) {
  FittedModel model;
  model.linearisation = std::make_shared<Linearisation>(measurement, terms);
  model.equations = std::make_shared<NormalEquations>(measurement, model.linearisation->columns(),
                                                      model.linearisation->target());
  model.constraints = constraints_of(terms, error_N);
  model.train_rmse_N = error_N;
  model.solution = model.equations->fit(model.constraints);
  model.terms = std::move(terms);
  return model;
}

}  // namespace slipstack::workbench
