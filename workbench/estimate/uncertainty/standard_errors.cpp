// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/standard_errors.h"

#include <algorithm>
#include <cmath>

#include "workbench/estimate/nonlinear/tangent.h"
#include "workbench/estimate/uncertainty/encoder_realisations.h"

namespace slipstack::workbench {
namespace {

/// Blocks are divided into parts of at least so many rows. Noise is uncorrelated over far fewer: the filter
/// reaches over nine. There are at most kMostParts per block: enough parts then contain what only few
/// movements excite, and finer ones give the same standard errors.
constexpr Eigen::Index kLeastRowsOfPart = 45;
constexpr Eigen::Index kMostParts = 4;

int parts_of_block(const Measurement& measurement) {
  const Eigen::Index rows = measurement.row_count() / std::max(1, measurement.block_count());
  return static_cast<int>(std::clamp<Eigen::Index>(rows / kLeastRowsOfPart, 1, kMostParts));
}

/// Variance of each unknown caused by the encoder's quantisation: the mean square of its change when an
/// encoder of equal resolution with a shifted grid reads the same motion. A log has only one grid. Where a
/// motion is repeated, its quantisation error and the resulting error of the hysteresis are repeated too, in
/// every block alike, so that the scatter between blocks does not contain them.
Eigen::VectorXd quantisation_variance(const Measurement& measurement, const FittedModel& fitted,
                                      const Tangent& tangent, const NormalEquations& equations,
                                      const BoundedSolution& solution) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(tangent.columns.cols());
  if (measurement.encoder_resolution_m() <= 0.0) return sum;
  const BoundedSolution here = equations.fit(tangent.constraints, solution.bound_states);
  Eigen::MatrixXd columns = tangent.columns;
  const std::vector<Measurement> realisations = encoder_realisations(measurement);
  for (const Measurement& realisation : realisations) {
    const Linearisation moved(realisation, fitted.terms);
    columns.leftCols(tangent.gains) = moved.columns();
    const NormalEquations other(measurement, columns, moved.target());
    sum += (other.fit(tangent.constraints, here.bound_states).value - here.value).cwiseAbs2();
  }
  return sum / static_cast<double>(realisations.size());
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
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
    // In another record the shape may come out anywhere in its range.
    const FreeShape& shape = tangent.shapes[i];
    const Eigen::Index column = tangent.column_of(i);
    if (tangent.constraints.upper(column) == 0.0) continue;
    const double value = fitted.terms[shape.term].shapes[shape.shape];
    tangent.constraints.lower(column) = shape.lower - value;
    tangent.constraints.upper(column) = shape.upper - value;
  }
  Eigen::VectorXd errors = equations.standard_errors(solution, tangent.constraints);
  const Eigen::VectorXd by_quantisation =
      quantisation_variance(measurement, fitted, tangent, equations, solution);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (errors(i) > 0.0) errors(i) = std::hypot(errors(i), std::sqrt(by_quantisation(i)));
  }

  Eigen::Index next = 0;
  for (Term& term : fitted.terms) {
    term.gain_standard_errors.assign(errors.data() + next,
                                     errors.data() + next + static_cast<Eigen::Index>(term.gains.size()));
    next += static_cast<Eigen::Index>(term.gains.size());
    term.shape_standard_errors.assign(term.shapes.size(), 0.0);
  }
  for (const FreeShape& shape : tangent.shapes) {
    fitted.terms[shape.term].shape_standard_errors[shape.shape] = errors(next++);
  }
  return fitted;
}

}  // namespace slipstack::workbench
