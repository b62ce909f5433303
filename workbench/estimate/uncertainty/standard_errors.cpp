// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/standard_errors.h"

#include <algorithm>
#include <cmath>

#include "workbench/estimate/nonlinear/shape_search.h"
#include "workbench/estimate/uncertainty/noise_floor.h"

namespace slipstack::workbench {
namespace {

/// Step of the central difference: of the shape where its range is logarithmic, else of the range. Far above
/// the steps of the firmware's tables and far below what bends the force.
constexpr double kRelativeStep = 3e-4;
/// A shape this close to an end of its range was stopped there.
constexpr double kAtItsBound = 1e-6;

/// Steps over which the tangent is trusted: 3 % of the shape.
constexpr double kFurthestSteps = 100.0;
/// What settling may cost in held-out error.
constexpr double kAsGoodHeldOut = 1.002;

/// Rows that noise forgets itself in, by far: the filter reaches over nine. And parts that a block is cut
/// into at most, so that enough of them tell of what only few moves show; finer ones give the same errors.
constexpr Eigen::Index kLongMemory_rows = 45;
constexpr Eigen::Index kMostParts = 4;

int parts_of_block(const Measurement& measurement) {
  const Eigen::Index rows = measurement.row_count() / std::max(1, measurement.block_count());
  return static_cast<int>(std::clamp<Eigen::Index>(rows / kLongMemory_rows, 1, kMostParts));
}

struct FreeShape {
  std::size_t term = 0;
  std::size_t shape = 0;
  double step = 0.0;
  double lower = 0.0;
  double upper = 0.0;
};

/// Shapes of a term that the log chose: of customary ones those that have left their customary value.
std::vector<ShapeRange> chosen_shapes(const Measurement& measurement, const Term& term) {
  std::vector<ShapeRange> ranges = searched_shapes(measurement, *term.effect);
  for (const ShapeRange& range : nominal_shapes(measurement, *term.effect)) {
    if (term.shapes[range.index] != range.nominal) ranges.push_back(range);
  }
  return ranges;
}

std::vector<FreeShape> free_shapes(const Measurement& measurement, const Terms& terms) {
  std::vector<FreeShape> shapes;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    for (const ShapeRange& range : chosen_shapes(measurement, terms[t])) {
      const double value = terms[t].shapes[range.index];
      const double margin = kAtItsBound * (range.upper - range.lower);
      if (value <= range.lower + margin || value >= range.upper - margin) continue;
      shapes.push_back({t, range.index,
                        kRelativeStep * (range.logarithmic ? value : range.upper - range.lower), range.lower,
                        range.upper});
    }
  }
  return shapes;
}

/// What the model leaves changes by minus this when a shape grows: derivative of modelled less measured
/// force, rows.
Eigen::VectorXd derivative(const Measurement& measurement, const FittedModel& fitted,
                           const FreeShape& shape) {
  const Terms& terms = fitted.terms;
  const std::vector<double>* dry_N =
      terms[shape.term].effect->acts_as(Acts::dry) ? nullptr : &fitted.linearisation->sample_dry_N();
  const auto difference_N = [&](double step) -> Eigen::VectorXd {
    Terms moved = terms;
    moved[shape.term].shapes[shape.shape] += step;
    // A lag moves the measured force, every other shape the model's.
    if (moved[shape.term].gains.empty()) return -measurement.force_N(measurement_dynamics_of(moved));
    return measurement.filtered(evaluate_force(measurement, moved, dry_N).force_N);
  };
  return (difference_N(shape.step) - difference_N(-shape.step)) / (2.0 * shape.step);
}

/// The model's unknowns about where it is: its gains as they are, and how far each shape should move.
struct Tangent {
  std::vector<FreeShape> shapes;
  Eigen::MatrixXd columns;
  NormalEquations::Constraints constraints;
  Eigen::Index gains = 0;
};

Tangent tangent_of(const Measurement& measurement, const FittedModel& fitted) {
  Tangent tangent;
  tangent.shapes = free_shapes(measurement, fitted.terms);
  const Eigen::MatrixXd& columns = fitted.linearisation->columns();
  tangent.gains = columns.cols();
  const Eigen::Index count = tangent.gains + static_cast<Eigen::Index>(tangent.shapes.size());
  tangent.columns.resize(columns.rows(), count);
  tangent.columns.leftCols(tangent.gains) = columns;
  tangent.constraints = fitted.constraints;
  tangent.constraints.penalty.conservativeResize(count, count);
  tangent.constraints.penalty.rightCols(count - tangent.gains).setZero();
  tangent.constraints.penalty.bottomRows(count - tangent.gains).setZero();
  tangent.constraints.lower.conservativeResize(count);
  tangent.constraints.upper.conservativeResize(count);
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
    const Eigen::Index column = tangent.gains + static_cast<Eigen::Index>(i);
    tangent.columns.col(column) = derivative(measurement, fitted, tangent.shapes[i]);
    // As far as the tangent holds; without gain, an effect's shapes say nothing.
    const bool seen = tangent.columns.col(column).squaredNorm() > 0.0;
    const double furthest = seen ? kFurthestSteps * tangent.shapes[i].step : 0.0;
    tangent.constraints.lower(column) = -furthest;
    tangent.constraints.upper(column) = furthest;
  }
  return tangent;
}

/// What the encoder's steps do to each unknown, mean square: how far it moves when another encoder of equal
/// resolution reads the same motion, its grid shifted. A record has one grid, and hysteresis of a motion that
/// is read wrongly by part of a step is wrong wherever that motion comes back, in each block alike: no
/// scatter between blocks tells of it.
Eigen::VectorXd reading_variance(const Measurement& measurement, const FittedModel& fitted,
                                 const Tangent& tangent, const NormalEquations& equations,
                                 const BoundedSolution& solution) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(tangent.columns.cols());
  if (measurement.encoder_resolution_m() <= 0.0) return sum;
  const BoundedSolution here = equations.fit(tangent.constraints, solution.bound_states);
  Eigen::MatrixXd columns = tangent.columns;
  const std::vector<Measurement> readings = encoder_realisations(measurement);
  for (const Measurement& reading : readings) {
    const Linearisation moved(reading, fitted.terms);
    columns.leftCols(tangent.gains) = moved.columns();
    const NormalEquations other(measurement, columns, moved.target());
    sum += (other.fit(tangent.constraints, here.bound_states).value - here.value).cwiseAbs2();
  }
  return sum / static_cast<double>(readings.size());
}

}  // namespace

FittedModel refine_all_shapes(const Measurement& measurement, FittedModel fitted) {
  Tangent tangent = tangent_of(measurement, fitted);
  if (tangent.shapes.empty()) return fitted;
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
    // The column of a low pass has the force's noise in it, which draws to no low pass at all.
    const FreeShape& shape = tangent.shapes[i];
    if (fitted.terms[shape.term].effect->shapes[shape.shape].kind != ShapeKind::filter) continue;
    const Eigen::Index column = tangent.gains + static_cast<Eigen::Index>(i);
    tangent.constraints.lower(column) = tangent.constraints.upper(column) = 0.0;
  }
  const NormalEquations equations(measurement, tangent.columns, fitted.linearisation->target());
  const Eigen::VectorXd value = equations.fit(tangent.constraints).value;
  Terms terms = fitted.terms;
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
    const FreeShape& shape = tangent.shapes[i];
    double& moved = terms[shape.term].shapes[shape.shape];
    moved = std::clamp(moved + value(tangent.gains + static_cast<Eigen::Index>(i)), shape.lower, shape.upper);
  }
  FittedModel converged = fit_gains(measurement, std::move(terms), &fitted);
  const bool better = converged.train_rmse_N < fitted.train_rmse_N &&
                      converged.holdout_rmse_N < kAsGoodHeldOut * fitted.holdout_rmse_N;
  return better ? converged : fitted;
}

FittedModel with_standard_errors(const Measurement& measurement, FittedModel fitted) {
  Tangent tangent = tangent_of(measurement, fitted);
  const Eigen::Index count = tangent.columns.cols();
  BoundedSolution solution = fitted.solution;
  solution.value.conservativeResize(count);
  solution.bound_states.resize(static_cast<std::size_t>(count), BoundState::free);
  for (Eigen::Index column = tangent.gains; column < count; ++column) {
    solution.value(column) = 0.0;  // how far the shape is from where it is
    if (tangent.constraints.upper(column) == 0.0)
      solution.bound_states[static_cast<std::size_t>(column)] = BoundState::on_lower;
  }
  const NormalEquations equations(measurement, tangent.columns, fitted.linearisation->target(),
                                  parts_of_block(measurement));
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
    // Another record's shape may be anywhere in its range.
    const FreeShape& shape = tangent.shapes[i];
    const Eigen::Index column = tangent.gains + static_cast<Eigen::Index>(i);
    if (tangent.constraints.upper(column) == 0.0) continue;
    const double value = fitted.terms[shape.term].shapes[shape.shape];
    tangent.constraints.lower(column) = shape.lower - value;
    tangent.constraints.upper(column) = shape.upper - value;
  }
  Eigen::VectorXd errors = equations.standard_errors(solution, tangent.constraints);
  const Eigen::VectorXd by_reading = reading_variance(measurement, fitted, tangent, equations, solution);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (errors(i) > 0.0) errors(i) = std::hypot(errors(i), std::sqrt(by_reading(i)));
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
