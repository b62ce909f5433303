// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/fit_gains.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "workbench/estimate/linear/tall_product.h"

namespace slipstack::workbench {
namespace {

/// Steps at most. Two or three suffice where products are small against the sums; a map that modulates most
/// of the force needs up to a dozen, effects that a log hardly tells apart up to ninety (tribometer).
constexpr int kMostSteps = 100;
/// Steps in which the scale of the prior follows the error. Afterwards it is held, so that the cost is one
/// function that can only fall.
constexpr int kScalingSteps = 3;
/// Relative decrease of the cost that ends the steps: the error is then known to half of this.
constexpr double kConverged = 1e-6;
/// Relative decrease of the cost that was promised and is not reached, from which a fit has not converged:
/// half of it is what the error may still fall by.
constexpr double kNotConverged = 2e-3;
/// The least damping, relative to the diagonal of the normal matrix, and the factor by which it grows and
/// falls (Marquardt 1963).
constexpr double kLeastDamping = 1e-7;
constexpr double kDampingFactor = 10.0;
/// Share of the promised decrease of the cost below which the next step is damped more, and above which it is
/// damped less (Nocedal & Wright 2006, algorithm 4.1).
constexpr double kPoorStep = 0.25;
constexpr double kGoodStep = 0.75;
constexpr double kLeastCost = std::numeric_limits<double>::min();
/// Trials of a step at most: the last is so short that it does not change the error that is printed.
constexpr int kMostTrials = 12;

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

/// A model with other gains, and what it leaves.
struct TriedGains {
  Terms terms;
  Eigen::VectorXd residual_N;
  DryTrace dry;  ///< evaluate_dry() of the terms, where it was needed
  double cost = 0.0;
};

/// The cost that a fit minimises: weighted squares of the residual and the penalty.
class PenalisedSquares {
 public:
  PenalisedSquares(const Measurement& measurement, const Linearisation& near,
                   const NormalEquations& equations, const NormalEquations::Constraints& constraints)
      : measurement_(measurement), near_(near), equations_(equations), constraints_(constraints) {}

  /// Of the model where it was linearised.
  double here(const Terms& terms) const { return of(near_.residual_N(), gains_of(terms)); }
  /// Of the model with other gains, and not of its linearisation.
  TriedGains at(const Terms& terms, const Eigen::VectorXd& gains) const {
    TriedGains trial{terms, {}, {}, 0.0};
    take_gains(trial.terms, gains);
    trial.residual_N = near_.residual_at(trial.terms, &trial.dry);
    trial.cost = of(trial.residual_N, gains);
    return trial;
  }
  /// Of the linearisation.
  double linearised(const Eigen::VectorXd& gains) const {
    return equations_.squared_error(gains) + penalty(gains);
  }
  /// The damped minimum of the linearisation.
  Eigen::VectorXd fit_near(const Eigen::VectorXd& here, double damping,
                           const std::vector<BoundState>& start) const {
    return equations_.fit_near(here, damping, constraints_, start).value;
  }
  /// The same with the curvature that a trial has shown: a second-order correction (Nocedal & Wright 2006
  /// ch. 18.3), exact along the step for a product of two gains.
  Eigen::VectorXd corrected(const TriedGains& trial, const Eigen::VectorXd& here, double damping,
                            const std::vector<BoundState>& start) const {
    const Eigen::VectorXd target =
        trial.residual_N + tall_combination(near_.columns(), gains_of(trial.terms));
    return equations_.with_target(measurement_, near_.columns(), target)
        .fit_near(here, damping, constraints_, start)
        .value;
  }

 private:
  double penalty(const Eigen::VectorXd& gains) const { return gains.dot(constraints_.penalty * gains); }
  double of(const Eigen::VectorXd& residual_N, const Eigen::VectorXd& gains) const {
    return measurement_.fit_weights().dot(residual_N.cwiseAbs2()) + penalty(gains);
  }

  const Measurement& measurement_;
  const Linearisation& near_;
  const NormalEquations& equations_;
  const NormalEquations::Constraints& constraints_;
};

bool within_bounds(const NormalEquations::Constraints& constraints, const Eigen::VectorXd& gains) {
  return (gains.array() >= constraints.lower.array()).all() &&
         (gains.array() <= constraints.upper.array()).all();
}

/// Steps of Levenberg and Marquardt within the bounds: of the linearised cost, plus the damping times the
/// squared change of each gain in units of its column (Marquardt 1963). Products of gains that the data
/// hardly tell apart bend the way to the minimum into a narrow valley: damped, a step is short along it only.
class DampedSteps {
 public:
  struct Step {
    double decrease = 0.0;  ///< of the cost, relative
    double promised = 0.0;  ///< of the linearised cost by the undamped step, relative
  };

  /// Moves the gains of `terms` so that the cost falls; where the linearisation promises less than
  /// kConverged, only the whole step, `whole`, is tried. `dry` becomes evaluate_dry() of the moved terms,
  /// empty where they stay.
  Step move(const PenalisedSquares& cost, double cost_here, const BoundedSolution& whole, Terms& terms,
            DryTrace& dry) {
    const double promised = 1.0 - cost.linearised(whole.value) / std::max(cost_here, kLeastCost);
    dry = {};
    const bool last = promised < kConverged;
    if (last) damping_ = 0.0;
    for (int trials = last ? 1 : kMostTrials; trials > 0; --trials) {
      TriedGains trial = tried(cost, cost_here, whole, terms);
      if (!(trial.cost < cost_here)) continue;
      terms = std::move(trial.terms);
      dry = std::move(trial.dry);
      return {1.0 - trial.cost / cost_here, promised};
    }
    return {0.0, promised};
  }

 private:
  /// One trial, and the damping of the next by how far it kept its promise.
  TriedGains tried(const PenalisedSquares& cost, double cost_here, const BoundedSolution& whole,
                   const Terms& terms) {
    const Eigen::VectorXd here = gains_of(terms);
    const Eigen::VectorXd there =
        damping_ == 0.0 ? whole.value : cost.fit_near(here, damping_, whole.bound_states);
    const double promised = cost_here - cost.linearised(there);
    TriedGains trial = cost.at(terms, there);
    if (cost_here - trial.cost < kPoorStep * promised) {
      TriedGains corrected = cost.at(terms, cost.corrected(trial, here, damping_, whole.bound_states));
      if (corrected.cost < trial.cost) trial = std::move(corrected);
    }
    const double decrease = cost_here - trial.cost;
    if (decrease < kPoorStep * promised) damping_ = std::max(kLeastDamping, kDampingFactor * damping_);
    if (decrease > kGoodStep * promised)
      damping_ = damping_ > kLeastDamping ? damping_ / kDampingFactor : 0.0;
    return trial;
  }

  double damping_ = 0.0;
};

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
  DampedSteps steps;
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
    const PenalisedSquares cost(measurement, *linearisation, *fitted.equations, fitted.constraints);
    const bool admissible = within_bounds(fitted.constraints, gains_of(terms));
    const double here = admissible ? cost.here(terms) : std::numeric_limits<double>::max();
    const DampedSteps::Step taken = steps.move(cost, here, fitted.solution, terms, dry);
    fitted.solution.value = gains_of(terms);
    fitted.converged = taken.promised - taken.decrease < kNotConverged;
    if (step > 0 && taken.decrease < kConverged && (taken.promised < kConverged || taken.decrease == 0.0))
      break;
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
