// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/tangent.h"

#include <algorithm>

#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {
namespace {

/// Step of the central difference, relative to the shape where its range is logarithmic, else to the range.
/// Far above the resolution of the firmware's tables and far below the scale on which the force is curved.
constexpr double kRelativeStep = 3e-4;

/// The tangent is trusted over this many steps, i.e. over 3 % of the shape.
constexpr double kFurthestSteps = 100.0;
/// Largest growth of the held-out error that a Gauss-Newton step may cause. Chosen.
constexpr double kAsGoodHeldOut = 1.002;

/// Shapes of a term that were chosen by the log: those with a nominal value only if they have left it, and no
/// pitch of one turn.
std::vector<ShapeRange> chosen_shapes(const Measurement& measurement, const Term& term) {
  std::vector<ShapeRange> ranges = searched_shapes(measurement, *term.effect);
  const auto pitch_m = term.shape(ShapeKind::pitch);
  if (pitch_m && is_one_turn(*pitch_m)) ranges.clear();
  for (const ShapeRange& range : nominal_shapes(measurement, *term.effect)) {
    if (term.shapes[range.index] != range.nominal) ranges.push_back(range);
  }
  return ranges;
}

double step_of(const ShapeRange& range, double value) {
  return kRelativeStep * (range.logarithmic ? value : range.upper - range.lower);
}

std::vector<FreeShape> free_shapes(const Measurement& measurement, const Terms& terms) {
  std::vector<FreeShape> shapes;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    for (const ShapeRange& range : chosen_shapes(measurement, terms[t])) {
      const double value = terms[t].shapes[range.index];
      if (is_at_bound(range, value)) continue;
      shapes.push_back({t, range.index, step_of(range, value), range.lower, range.upper});
    }
  }
  return shapes;
}

}  // namespace

std::vector<FreeShape> shapes_at_bounds(const Measurement& measurement, const Terms& terms) {
  std::vector<FreeShape> shapes;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    for (const ShapeRange& range : chosen_shapes(measurement, terms[t])) {
      const double value = terms[t].shapes[range.index];
      if (!is_at_bound(range, value)) continue;
      const ShapeSpec& spec = terms[t].effect->shapes[range.index];
      shapes.push_back({t, range.index, step_of(range, value), static_cast<double>(spec.lower),
                        static_cast<double>(spec.upper)});
    }
  }
  return shapes;
}

Eigen::VectorXd derivative_by_shape(const Measurement& measurement, const FittedModel& fitted,
                                    const FreeShape& shape) {
  const Terms& terms = fitted.terms;
  const auto difference_N = [&](double step) -> Eigen::VectorXd {
    Terms moved = terms;
    moved[shape.term].shapes[shape.shape] += step;
    // A delay acts on the measured force, every other shape on the model's.
    if (moved[shape.term].gains.empty()) return -measurement.force_N(measurement_dynamics_of(moved));
    return fitted.linearisation->force_at(moved);
  };
  return (difference_N(shape.step) - difference_N(-shape.step)) / (2.0 * shape.step);
}

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
    const Eigen::Index column = tangent.column_of(i);
    tangent.columns.col(column) = derivative_by_shape(measurement, fitted, tangent.shapes[i]);
    // As far as the tangent holds. The shapes of an effect with zero gain have no influence on the force.
    const bool has_influence = tangent.columns.col(column).squaredNorm() > 0.0;
    const double furthest = has_influence ? kFurthestSteps * tangent.shapes[i].step : 0.0;
    tangent.constraints.lower(column) = -furthest;
    tangent.constraints.upper(column) = furthest;
  }
  return tangent;
}

void hold_low_pass(const FittedModel& fitted, Tangent& tangent) {
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
    const FreeShape& shape = tangent.shapes[i];
    if (fitted.terms[shape.term].effect->shapes[shape.shape].kind != ShapeKind::filter) continue;
    const Eigen::Index column = tangent.column_of(i);
    tangent.constraints.lower(column) = tangent.constraints.upper(column) = 0.0;
  }
}

FittedModel refine_all_shapes(const Measurement& measurement, FittedModel fitted) {
  Tangent tangent = tangent_of(measurement, fitted);
  if (tangent.shapes.empty()) return fitted;
  hold_low_pass(fitted, tangent);
  const NormalEquations equations(measurement, tangent.columns, fitted.linearisation->target());
  const Eigen::VectorXd value = equations.fit(tangent.constraints).value;
  Terms terms = fitted.terms;
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
    const FreeShape& shape = tangent.shapes[i];
    double& moved = terms[shape.term].shapes[shape.shape];
    moved = std::clamp(moved + value(tangent.column_of(i)), shape.lower, shape.upper);
  }
  FittedModel converged = fit_gains(measurement, std::move(terms), &fitted);
  const bool better = converged.train_rmse_N < fitted.train_rmse_N &&
                      converged.holdout_rmse_N < kAsGoodHeldOut * fitted.holdout_rmse_N;
  return better ? converged : fitted;
}

}  // namespace slipstack::workbench
