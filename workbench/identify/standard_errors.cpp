// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/standard_errors.h"

#include <algorithm>

#include "workbench/identify/shape_search.h"

namespace slipstack::workbench {
namespace {

/// Step of the central difference: of the shape where its range is logarithmic, else of the range. Far above
/// the steps of the firmware's tables and far below what bends the force.
constexpr double kRelativeStep = 3e-4;
/// A shape this close to an end of its range was stopped there.
constexpr double kAtItsBound = 1e-6;

struct FreeShape {
  std::size_t term = 0;
  std::size_t shape = 0;
  double step = 0.0;
};

std::vector<FreeShape> free_shapes(const Measurement& measurement, const Terms& terms) {
  std::vector<FreeShape> shapes;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    for (const ShapeRange& range : searched_shapes(measurement, *terms[t].effect)) {
      const double value = terms[t].shapes[range.index];
      const double margin = kAtItsBound * (range.upper - range.lower);
      if (value <= range.lower + margin || value >= range.upper - margin) continue;
      shapes.push_back(
          {t, range.index, kRelativeStep * (range.logarithmic ? value : range.upper - range.lower)});
    }
  }
  return shapes;
}

/// What the model leaves changes by minus this when a shape grows: derivative of modelled less measured
/// force, rows.
Eigen::VectorXd derivative(const Measurement& measurement, const Terms& terms, const FreeShape& shape) {
  const auto difference_N = [&](double step) -> Eigen::VectorXd {
    Terms moved = terms;
    moved[shape.term].shapes[shape.shape] += step;
    // A delay moves the measured force, every other shape the model's.
    if (moved[shape.term].gains.empty()) return -measurement.force_N(delay_s(moved));
    return measurement.filtered(evaluate_force(measurement, moved).force_N);
  };
  return (difference_N(shape.step) - difference_N(-shape.step)) / (2.0 * shape.step);
}

}  // namespace

FittedModel with_standard_errors(const Measurement& measurement, FittedModel fitted) {
  const std::vector<FreeShape> shapes = free_shapes(measurement, fitted.terms);
  const Eigen::MatrixXd& columns = fitted.linearisation->columns();
  const Eigen::Index gains = columns.cols();
  const Eigen::Index count = gains + static_cast<Eigen::Index>(shapes.size());

  Eigen::MatrixXd all(columns.rows(), count);
  all.leftCols(gains) = columns;
  BoundedSolution solution = fitted.solution;
  solution.value.conservativeResize(count);
  solution.rests.resize(static_cast<std::size_t>(count), Rests::free);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Eigen::Index column = gains + static_cast<Eigen::Index>(i);
    all.col(column) = derivative(measurement, fitted.terms, shapes[i]);
    solution.value(column) = 0.0;  // how far the shape is from where it is
    // Without gain, an effect's shapes say nothing.
    if (all.col(column).squaredNorm() == 0.0)
      solution.rests[static_cast<std::size_t>(column)] = Rests::on_lower;
  }
  NormalEquations::Constraints constraints = fitted.constraints;
  constraints.penalty.conservativeResize(count, count);
  constraints.penalty.rightCols(count - gains).setZero();
  constraints.penalty.bottomRows(count - gains).setZero();
  const NormalEquations equations(measurement, all, fitted.linearisation->target());
  const Eigen::VectorXd errors = equations.standard_errors(solution, constraints);

  Eigen::Index next = 0;
  for (Term& term : fitted.terms) {
    term.gain_standard_errors.assign(errors.data() + next,
                                     errors.data() + next + static_cast<Eigen::Index>(term.gains.size()));
    next += static_cast<Eigen::Index>(term.gains.size());
    term.shape_standard_errors.assign(term.shapes.size(), 0.0);
  }
  for (const FreeShape& shape : shapes) {
    fitted.terms[shape.term].shape_standard_errors[shape.shape] = errors(next++);
  }
  return fitted;
}

}  // namespace slipstack::workbench
