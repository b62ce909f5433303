// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/instruments.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "workbench/estimate/linear/force_trace.h"
#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {
namespace {

using Eigen::Index;

/// Taps of an impulse response to either side, one for each distance between rows: five periods of the
/// bandwidth, several time constants of a loop that moves the axis within the bandwidth. Chosen; on simulated
/// axes a tracking error of 10 to 47 um leaves 4 to 5 um, and a second pass, with the force along the
/// response, leaves no less.
constexpr int kTaps = 16;
constexpr double kRelativeRidge = 1e-9;

/// A signal smoothed as the motion is, within each part.
std::vector<double> smoothed_as_motion(const Measurement& measurement, const std::vector<double>& signal) {
  const std::vector<double> taps = motion_taps(measurement.bandwidth_Hz(), measurement.sample_rate_Hz());
  std::vector<double> all;
  all.reserve(signal.size());
  for (const LogPart& part : measurement.parts()) {
    const std::vector<double> own = filter_all(part_of(signal, part), taps);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

/// The values of each input around a sample of a part, a row of a regression; beyond the part its first or
/// last value.
template <class Row>
void take_taps(const Measurement& measurement, const std::vector<std::vector<double>>& inputs,
               const LogPart& part, std::size_t sample, Row&& row) {
  const auto first = static_cast<std::ptrdiff_t>(part.first_sample);
  const auto last = static_cast<std::ptrdiff_t>(part.end_sample()) - 1;
  const auto stride = static_cast<std::ptrdiff_t>(measurement.row_stride());
  Index next = 0;
  for (const std::vector<double>& input : inputs) {
    for (int tap = -kTaps; tap <= kTaps; ++tap) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(sample) + tap * stride;
      row(next++) = input[static_cast<std::size_t>(std::clamp(at, first, last))];
    }
  }
}

/// The reference plus the response of the position's deviation from it to the inputs, by impulse responses
/// that are fitted at the rows.
std::vector<double> response(const Measurement& measurement, const std::vector<double>& reference_m,
                             const std::vector<std::vector<double>>& inputs) {
  const Index count = (2 * kTaps + 1) * static_cast<Index>(inputs.size());
  Eigen::MatrixXd regressors(measurement.row_count(), count);
  Eigen::VectorXd deviation_m(measurement.row_count());
  for (Index row = 0; row < measurement.row_count(); ++row) {
    const std::size_t sample = measurement.row_samples()[static_cast<std::size_t>(row)];
    take_taps(measurement, inputs, measurement.parts()[measurement.part_at(sample)], sample,
              regressors.row(row));
    deviation_m(row) = measurement.position_m()[sample] - reference_m[sample];
  }
  const Eigen::VectorXd& usable = measurement.row_usable();
  Eigen::MatrixXd normal = regressors.transpose() * usable.asDiagonal() * regressors;
  const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  normal = scale.asDiagonal() * normal * scale.asDiagonal();
  normal.diagonal().array() += kRelativeRidge;
  const Eigen::VectorXd right = regressors.transpose() * usable.cwiseProduct(deviation_m);
  const Eigen::VectorXd taps = scale.cwiseProduct(normal.ldlt().solve(scale.cwiseProduct(right)));
  std::vector<double> position_m = reference_m;
  Eigen::RowVectorXd around(count);
  for (const LogPart& part : measurement.parts()) {
    for (std::size_t i = part.first_sample; i < part.end_sample(); ++i) {
      take_taps(measurement, inputs, part, i, around);
      position_m[i] += around.dot(taps);
    }
  }
  return position_m;
}

/// The columns of the tangent along the motion that the reference alone causes.
Eigen::MatrixXd instruments(const Measurement& measurement, const FittedModel& fitted,
                            const Tangent& tangent) {
  const std::vector<double>& force_N = measurement.log().force_N;
  const std::vector<double> reference_m =
      smoothed_as_motion(measurement, measurement.log().reference_position_m);
  const auto force_along = [&](const std::vector<double>& position_m) {
    return evaluate_force(measurement.with_motion(position_m, force_N), fitted.terms).force_N;
  };
  const std::vector<double> position_m = response(
      measurement, reference_m, {reference_m, smoothed_as_motion(measurement, force_along(reference_m))});
  // A delay acts on the measured force, here on the model's.
  const Measurement clean = measurement.with_motion(position_m, force_along(position_m));
  FittedModel along = fitted;
  along.linearisation = std::make_shared<const Linearisation>(clean, fitted.terms);
  Eigen::MatrixXd columns(clean.row_count(), tangent.columns.cols());
  columns.leftCols(tangent.gains) = along.linearisation->columns();
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i)
    columns.col(tangent.column_of(i)) = derivative_by_shape(clean, along, tangent.shapes[i]);
  return columns;
}

/// Directions in which the unknowns may be biased, one in each column: each free unknown, all elements of a
/// hysteresis together.
Eigen::MatrixXd directions_of(const FittedModel& fitted, const Tangent& tangent,
                              const BoundedSolution& solution) {
  const Index count = tangent.columns.cols();
  std::vector<bool> free(static_cast<std::size_t>(count));
  std::transform(solution.bound_states.begin(), solution.bound_states.end(), free.begin(),
                 [](BoundState state) { return state == BoundState::free; });
  for (const auto& [a, b] : tangent.constraints.pairs) {  // their states are those of sum and difference
    const bool both = free[static_cast<std::size_t>(a)] && free[static_cast<std::size_t>(b)];
    free[static_cast<std::size_t>(a)] = free[static_cast<std::size_t>(b)] = both;
  }
  for (std::size_t i = 0; i < tangent.shapes.size(); ++i) {
    const FreeShape& shape = tangent.shapes[i];
    if (fitted.terms[shape.term].effect->shapes[shape.shape].kind == ShapeKind::filter)
      free[static_cast<std::size_t>(tangent.column_of(i))] = false;
  }
  std::vector<Eigen::VectorXd> directions;
  Index next = 0;
  for (const Term& term : fitted.terms) {
    const auto own = static_cast<Index>(term.gains.size());
    if (term.effect->has_role(Role::hysteresis)) {
      Eigen::VectorXd all = Eigen::VectorXd::Zero(count);
      all.segment(next, own) = solution.value.segment(next, own);
      if (all.squaredNorm() > 0.0) directions.push_back(std::move(all));
      std::fill_n(free.begin() + next, own, false);
    }
    next += own;
  }
  for (Index i = 0; i < count; ++i) {
    if (free[static_cast<std::size_t>(i)]) directions.emplace_back(Eigen::VectorXd::Unit(count, i));
  }
  Eigen::MatrixXd columns(count, static_cast<Index>(directions.size()));
  for (Index i = 0; i < columns.cols(); ++i) columns.col(i) = directions[static_cast<std::size_t>(i)];
  return columns;
}

/// Whether the position is that of a controller that follows the reference of the log.
bool is_under_control(const Measurement& measurement) {
  const std::vector<double>& reference_m = measurement.log().reference_position_m;
  return reference_m.size() == measurement.sample_count() && reference_m != measurement.log().position_m &&
         std::all_of(reference_m.begin(), reference_m.end(),
                     [](double value) { return std::isfinite(value); });
}

}  // namespace

Eigen::VectorXd squared_bias_by_control(const Measurement& measurement, const FittedModel& fitted,
                                        const Tangent& tangent, const BoundedSolution& solution,
                                        const Eigen::MatrixXd& sums) {
  const Index count = tangent.columns.cols();
  Eigen::VectorXd none = Eigen::VectorXd::Zero(count + sums.cols());
  if (!is_under_control(measurement)) return none;
  const Eigen::MatrixXd directions = directions_of(fitted, tangent, solution);
  if (directions.cols() == 0) return none;
  Eigen::MatrixXd columns = tangent.columns * directions;
  const Eigen::VectorXd scale = columns.colwise().norm().cwiseMax(1e-300).cwiseInverse().transpose();
  columns = columns * scale.asDiagonal();
  const Eigen::MatrixXd instrument =
      instruments(measurement, fitted, tangent) * directions * scale.asDiagonal();
  const Eigen::VectorXd& weights = measurement.fit_weights();
  const Eigen::FullPivLU<Eigen::MatrixXd> least_squares(columns.transpose() * weights.asDiagonal() * columns);
  const Eigen::FullPivLU<Eigen::MatrixXd> by_instruments(instrument.transpose() * weights.asDiagonal() *
                                                         columns);
  if (!least_squares.isInvertible() || !by_instruments.isInvertible()) return none;
  Eigen::VectorXd left = fitted.linearisation->target() - tangent.columns * solution.value;
  left -= columns * least_squares.solve(columns.transpose() * weights.cwiseProduct(left));
  // What the residual of some rows makes of the difference of both estimates, and of its sums.
  const auto difference = [&](Index first, Index rows) {
    const Eigen::VectorXd weighted = weights.segment(first, rows).cwiseProduct(left.segment(first, rows));
    const Eigen::VectorXd moved =
        directions * (scale.asDiagonal() *
                      (by_instruments.solve(instrument.middleRows(first, rows).transpose() * weighted) -
                       least_squares.solve(columns.middleRows(first, rows).transpose() * weighted)));
    Eigen::VectorXd all(count + sums.cols());
    all << moved, sums.transpose() * moved;
    return all;
  };
  Eigen::VectorXd squares = difference(0, measurement.row_count()).cwiseAbs2();
  for (const RowRange& range : block_ranges(measurement, parts_of_block(measurement)))
    squares -= difference(range.first, range.count).cwiseAbs2();
  return squares.cwiseMax(0.0);
}

}  // namespace slipstack::workbench
