// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/standard_errors.h"

#include <algorithm>
#include <cmath>

#include "workbench/estimate/nonlinear/tangent.h"
#include "workbench/estimate/uncertainty/encoder_realisations.h"
#include "workbench/estimate/uncertainty/instruments.h"

namespace slipstack::workbench {
namespace {

/// Variance of each unknown by the encoder's quantisation that the scatter between blocks does not contain. A
/// log has only one grid. Where a motion is repeated, its quantisation error and the resulting error of the
/// hysteresis are repeated too, in every block alike.
Eigen::VectorXd quantisation_variance(const Measurement& measurement, const FittedModel& fitted,
                                      const Tangent& tangent, const NormalEquations& equations,
                                      const BoundedSolution& solution, const Eigen::MatrixXd& sums) {
  if (measurement.encoder_resolution_m() <= 0.0)
    return Eigen::VectorXd::Zero(tangent.columns.cols() + sums.cols());
  const ForceChanges changes_N = changes_by_quantisation_N(measurement, {&fitted.terms}, 0).front();
  return equations.recurring_variance(measurement, tangent.columns, changes_N, solution, tangent.constraints,
                                      sums);
}

/// Change of each unknown where the shapes that ended at a bound of their search are let go, as far as the
/// effect's own bounds: what the others would be worth if the search had not ended there. Scatter does not
/// contain it, because in each block the bound is the same.
Eigen::VectorXd change_by_bounds(const Measurement& measurement, const FittedModel& fitted,
                                 const Tangent& tangent, const NormalEquations& equations,
                                 const BoundedSolution& solution) {
  const Eigen::Index count = tangent.columns.cols();
  const std::vector<FreeShape> held = shapes_at_bounds(measurement, fitted.terms);
  if (held.empty()) return Eigen::VectorXd::Zero(count);
  const auto added = static_cast<Eigen::Index>(held.size());
  Eigen::MatrixXd further(tangent.columns.rows(), added);
  NormalEquations::Constraints constraints = tangent.constraints;
  constraints.lower.conservativeResize(count + added);
  constraints.upper.conservativeResize(count + added);
  constraints.penalty.conservativeResizeLike(Eigen::MatrixXd::Zero(count + added, count + added));
  for (Eigen::Index i = 0; i < added; ++i) {
    const FreeShape& shape = held[static_cast<std::size_t>(i)];
    const double value = fitted.terms[shape.term].shapes[shape.shape];
    further.col(i) = derivative_by_shape(measurement, fitted, shape);
    const bool has_influence = further.col(i).squaredNorm() > 0.0;
    constraints.lower(count + i) = has_influence ? shape.lower - value : 0.0;
    constraints.upper(count + i) = has_influence ? shape.upper - value : 0.0;
  }
  const Eigen::VectorXd& target = fitted.linearisation->target();
  const NormalEquations wider = equations.sum_with(measurement, tangent.columns, further, target);
  std::vector<BoundState> start = solution.bound_states;
  start.resize(static_cast<std::size_t>(count + added), BoundState::free);
  return wider.fit(constraints, start).value.head(count) -
         equations.fit(tangent.constraints, solution.bound_states).value;
}

/// What is told of sums of unknowns, one in each column: the totals of the gains of each term and set of
/// gains, then the lag of the force, by delay and filter together, if the model has one.
Eigen::MatrixXd sums_of(const Terms& terms, const Tangent& tangent) {
  const Eigen::Index unknowns = tangent.columns.cols();
  std::vector<Eigen::VectorXd> sums;
  Eigen::Index next = 0;
  for (const Term& term : terms) {
    const auto count = static_cast<Eigen::Index>(term.gains_per_set());
    const std::vector<double> weights = total_weights(term);
    for (std::size_t set = 0; !term.gains.empty() && set < term.gain_sets(); ++set, next += count) {
      if (weights.empty()) continue;
      sums.emplace_back(Eigen::VectorXd::Zero(unknowns));
      sums.back().segment(next, count) = Eigen::Map<const Eigen::VectorXd>(weights.data(), count);
    }
  }
  if (has_role(terms, Role::measurement_delay)) {
    sums.emplace_back(Eigen::VectorXd::Zero(unknowns));
    for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
      if (terms[tangent.shapes[i].term].effect->has_role(Role::measurement_delay))
        sums.back()(tangent.column_of(i)) = 1.0;
    }
  }
  Eigen::MatrixXd columns(unknowns, static_cast<Eigen::Index>(sums.size()));
  for (std::size_t i = 0; i < sums.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = sums[i];
  return columns;
}

/// Hands the errors of the unknowns and, after them, of the sums to the terms.
void take_errors(const Eigen::VectorXd& errors, const Tangent& tangent, Terms& terms) {
  const double* next = errors.data();
  for (Term& term : terms) {
    term.gain_standard_errors.assign(next, next + term.gains.size());
    next += term.gains.size();
    term.shape_standard_errors.assign(term.shapes.size(), 0.0);
    term.total_standard_errors.clear();
  }
  for (const FreeShape& shape : tangent.shapes)
    terms[shape.term].shape_standard_errors[shape.shape] = *next++;
  for (Term& term : terms) {
    if (total_weights(term).empty()) continue;
    term.total_standard_errors.assign(next, next + term.gain_sets());
    next += term.gain_sets();
  }
  for (Term& term : terms) {
    if (term.effect->has_role(Role::measurement_delay)) term.lag_standard_error_s = *next++;
  }
}

}  // namespace

FittedModel with_standard_errors(const Measurement& measurement, FittedModel fitted) {
  Tangent tangent = tangent_of(measurement, fitted);
  const Eigen::Index count = tangent.columns.cols();
  BoundedSolution solution = fitted.solution;
  solution.value.conservativeResize(count);
  solution.bound_states.resize(static_cast<std::size_t>(count), BoundState::free);
  for (Eigen::Index column = tangent.gains; column < count; ++column) {
    solution.value(column) = 0.0;  // the change of the shape, which is zero at the solution
    if (tangent.constraints.upper(column) == 0.0)
      solution.bound_states[static_cast<std::size_t>(column)] = BoundState::on_lower;
  }
  const NormalEquations equations(measurement, tangent.columns, fitted.linearisation->target(),
                                  parts_of_block(measurement));
  // Where a search of the shapes stopped beside the minimum: the step to it.
  const Eigen::VectorXd beside =
      equations.fit(tangent.constraints, solution.bound_states).value - solution.value;
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
    // In another record the shape may come out anywhere in its range.
    const FreeShape& shape = tangent.shapes[i];
    const Eigen::Index column = tangent.column_of(i);
    if (tangent.constraints.upper(column) == 0.0) continue;
    const double value = fitted.terms[shape.term].shapes[shape.shape];
    tangent.constraints.lower(column) = shape.lower - value;
    tangent.constraints.upper(column) = shape.upper - value;
  }
  const Eigen::MatrixXd sums = sums_of(fitted.terms, tangent);
  Eigen::VectorXd errors = equations.standard_errors(solution, tangent.constraints, sums);
  Eigen::VectorXd unseen = quantisation_variance(measurement, fitted, tangent, equations, solution, sums);
  const auto add_square = [&](const Eigen::VectorXd& change) {
    unseen.head(count) += change.cwiseAbs2();
    unseen.tail(sums.cols()) += (sums.transpose() * change).cwiseAbs2();
  };
  add_square(beside);
  add_square(change_by_bounds(measurement, fitted, tangent, equations, solution));
  unseen += squared_bias_by_control(measurement, fitted, tangent, solution, sums);
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    if (errors(i) > 0.0) errors(i) = std::hypot(errors(i), std::sqrt(unseen(i)));
  }
  take_errors(errors, tangent, fitted.terms);
  return fitted;
}

}  // namespace slipstack::workbench
