// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/fit_gains.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "workbench/estimate/nonlinear/damped_step.h"

namespace slipstack::workbench {
namespace {

/// Gauss-Newton steps at most. Two or three suffice where products are small against the sums; a map that
/// modulates most of the force needs up to a dozen (tribometer).
constexpr int kMostSteps = 40;
/// Steps in which the scale of the prior follows the error. Afterwards it is held, so that the cost is one
/// function that can only fall.
constexpr int kScalingSteps = 3;
/// Relative decrease of the cost that ends the steps: the error is then known to half of this.
constexpr double kConverged = 1e-6;
/// A step is halved at most so often; a smaller one does not change the error that is printed.
constexpr int kMostHalvings = 10;

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

/// The cost that a fit minimises, of the model itself and not of its linearisation: weighted squares of the
/// residual and the penalty.
class PenalisedSquares {
 public:
  PenalisedSquares(const Measurement& measurement, const Linearisation& near, const Eigen::MatrixXd& penalty)
      : measurement_(measurement), near_(near), penalty_(penalty) {}
  double of(const Eigen::VectorXd& residual_N, const Eigen::VectorXd& gains) const {
    return measurement_.fit_weights().dot(residual_N.cwiseAbs2()) + gains.dot(penalty_ * gains);
  }
  /// `dry`: set to evaluate_dry() of the terms, where they have products.
  double of(const Terms& terms, DryTrace& dry) const {
    return of(near_.residual_at(terms, &dry), gains_of(terms));
  }

 private:
  const Measurement& measurement_;
  const Linearisation& near_;
  const Eigen::MatrixXd& penalty_;
};

bool within_bounds(const NormalEquations::Constraints& constraints, const Eigen::VectorXd& gains) {
  return (gains.array() >= constraints.lower.array()).all() &&
         (gains.array() <= constraints.upper.array()).all();
}

/// Moves the gains of `terms` towards `wanted`, as far as the cost falls: the bounds are convex, so any part
/// of the way between two admissible points is admissible. Where the linearisation promises less than
/// kConverged (`cost_promised`), only the whole step is tried. `dry` becomes evaluate_dry() of the moved
/// terms, empty where they stay. Returns the relative decrease of the cost.
double step_towards(const PenalisedSquares& cost, double cost_here, double cost_promised,
                    const Eigen::VectorXd& wanted, Terms& terms, DryTrace& dry) {
  dry = {};
  const Eigen::VectorXd here = gains_of(terms);
  double cost_there = cost_here;
  const bool converged = cost_promised > (1.0 - kConverged) * cost_here;
  const bool taken = take_damped_step(converged ? 0 : kMostHalvings, [&](double share) {
    Terms moved = terms;
    take_gains(moved, here + share * (wanted - here));
    DryTrace dry_there;
    cost_there = cost.of(moved, dry_there);
    if (!(cost_there < cost_here)) return false;
    terms = std::move(moved);
    dry = std::move(dry_there);
    return true;
  });
  return taken ? 1.0 - cost_there / cost_here : 0.0;
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
  set_errors_in_sample(measurement, fitted);
}

}  // namespace

void set_errors_in_sample(const Measurement& measurement, FittedModel& model) {
  const Eigen::VectorXd residual_N = model.linearisation->residual_N();
  const Eigen::VectorXd& usable = measurement.row_usable();
  model.train_rmse_N = measurement.weighted_rms(residual_N);
  model.relative_error = residual_N.cwiseProduct(usable).norm() /
                         std::max(model.linearisation->measured_N().cwiseProduct(usable).norm(), 1e-300);
}

FittedModel fit_gains(const Measurement& measurement, Terms terms, const FittedModel* known) {
  const double noise_N = measurement.filtered_force_noise_N();
  const bool products = any_multiplies(terms);
  if (products && !dry_friction_known(terms)) fit_without_products(measurement, terms, noise_N);

  FittedModel fitted;
  double error_N = known == nullptr ? noise_N : known->train_rmse_N;
  std::shared_ptr<const Linearisation> linearisation;
  std::shared_ptr<const Linearisation> lender = known == nullptr ? nullptr : known->linearisation;
  DryTrace dry;  // of the terms, where it is known
  for (int step = 0; step < kMostSteps; ++step) {
    linearisation = std::make_shared<Linearisation>(measurement, terms, lender.get(), std::exchange(dry, {}));
    lender = linearisation;
    fitted.equations =
        std::make_shared<NormalEquations>(measurement, linearisation->columns(), linearisation->target());
    fitted.constraints = constraints_of(terms, error_N);
    fitted.solution = fitted.equations->fit(fitted.constraints, fitted.solution.bound_states);
    if (!products) {
      take_gains(terms, fitted.solution.value);
      break;
    }
    if (step < kScalingSteps) {
      error_N =
          std::sqrt(fitted.equations->squared_error(fitted.solution.value) / fitted.equations->weight());
    }
    const PenalisedSquares cost(measurement, *linearisation, fitted.constraints.penalty);
    const bool admissible = within_bounds(fitted.constraints, gains_of(terms));
    const double here = admissible ? cost.of(linearisation->residual_N(), gains_of(terms))
                                   : std::numeric_limits<double>::max();
    const Eigen::VectorXd& wanted = fitted.solution.value;
    const double promised =
        fitted.equations->squared_error(wanted) + wanted.dot(fitted.constraints.penalty * wanted);
    const double decrease = step_towards(cost, here, promised, wanted, terms, dry);
    fitted.solution.value = gains_of(terms);
    if (step > 0 && decrease < kConverged) break;
  }
  // Linearised again at the final gains: residuals and trials start from here.
  fitted.linearisation = std::make_shared<Linearisation>(*linearisation, terms, std::move(dry));
  fitted.terms = std::move(terms);
  judge(measurement, fitted);
  return fitted;
}

FittedModel linearised(const Measurement& measurement, Terms terms, double error_N,
                       const FittedModel* known) {
  FittedModel model;
  model.linearisation = std::make_shared<Linearisation>(
      measurement, terms, known == nullptr ? nullptr : known->linearisation.get());
  model.equations = std::make_shared<NormalEquations>(measurement, model.linearisation->columns(),
                                                      model.linearisation->target());
  model.constraints = constraints_of(terms, error_N);
  model.train_rmse_N = error_N;
  model.solution = model.equations->fit(model.constraints);
  model.terms = std::move(terms);
  return model;
}

}  // namespace slipstack::workbench
