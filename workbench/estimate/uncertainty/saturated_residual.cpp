// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/saturated_residual.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "workbench/base/linear_systems.h"
#include "workbench/base/parallel.h"
#include "workbench/signal/free_curve.h"

namespace slipstack::workbench {
namespace {

/// At most so many intervals per curve, as many as a map of the catalogue has (17), and fewer over time,
/// because what drifts is slow: a curve with more of them fits what the encoder's steps do wherever the axis
/// stands. So many rows for each, so that the curves take a few per cent of the degrees of freedom.
constexpr int kMostIntervals = 17;
constexpr int kIntervalsOfTime = 6;
constexpr Eigen::Index kRowsPerInterval = 200;
/// Regularisation relative to a diagonal of one: columns may be equal, as of time and position in one
/// traverse.
constexpr double kRidge = 1e-7;

/// A free curve over a coordinate; each row's value is multiplied by `factor`.
struct Curve {
  Eigen::VectorXd coordinate;
  Eigen::VectorXd factor;
  std::vector<double> knots;
  Eigen::Index first_column = 0;
};

std::vector<Curve> curves_of(const Measurement& measurement, const Linearisation& model) {
  const Eigen::Index rows = measurement.row_count();
  Eigen::VectorXd position_m(rows);
  Eigen::VectorXd velocity_mps(rows);
  Eigen::VectorXd acceleration_mps2(rows);
  Eigen::VectorXd time_s(rows);
  Eigen::VectorXd dry_N(rows);
  const std::vector<double>& sample_dry_N = model.sample_dry_N();
  for (Eigen::Index row = 0; row < rows; ++row) {
    const std::size_t sample = measurement.row_samples()[static_cast<std::size_t>(row)];
    position_m(row) = measurement.position_m()[sample];
    velocity_mps(row) = measurement.velocity_mps()[sample];
    acceleration_mps2(row) = measurement.acceleration_mps2()[sample];
    time_s(row) = measurement.time_s(sample);
    dry_N(row) = sample_dry_N[sample];
  }
  const auto intervals =
      static_cast<int>(std::clamp<Eigen::Index>(rows / kRowsPerInterval, 1, kMostIntervals));
  std::vector<Curve> curves;
  const auto add = [&](Eigen::VectorXd coordinate, Eigen::VectorXd factor, int most) {
    Curve curve;
    curve.knots = knots_over(coordinate, std::min(intervals, most));
    curve.coordinate = std::move(coordinate);
    curve.factor = std::move(factor);
    curves.push_back(std::move(curve));
  };
  Eigen::VectorXd absolute_mps2 = acceleration_mps2.cwiseAbs();
  for (const auto* alone : {&position_m, &velocity_mps, &acceleration_mps2})
    add(*alone, Eigen::VectorXd::Ones(rows), kMostIntervals);
  for (const auto* modulating : {&position_m, &absolute_mps2}) add(*modulating, dry_N, kMostIntervals);
  add(time_s, Eigen::VectorXd::Ones(rows), kIntervalsOfTime);
  add(time_s, dry_N, kIntervalsOfTime);
  return curves;
}

/// The values of a row that are not zero, with their columns.
struct SparseRow {
  std::vector<std::pair<Eigen::Index, double>> values;

  void fill(const std::vector<Curve>& curves, Eigen::Index row) {
    values.clear();
    for (const Curve& curve : curves) {
      const HatWeights hats = hat_weights(curve.coordinate(row), curve.knots);
      for (std::size_t i = 0; i < hats.weight.size(); ++i) {
        if (hats.weight[i] == 0.0) continue;
        values.emplace_back(curve.first_column + static_cast<Eigen::Index>(hats.below + i),
                            hats.weight[i] * curve.factor(row));
      }
    }
  }
};

/// Parts of the rows that are summed up on their own: as many on every machine, so that the sums are the
/// same.
constexpr std::size_t kParts = 8;

/// Calls visit(part, first row, end) for all parts of so many rows, on all usable processors.
template <class Visit>
void in_parts(Eigen::Index rows, Visit&& visit) {
  const auto border = [rows](std::size_t part) {
    return rows * static_cast<Eigen::Index>(part) / static_cast<Eigen::Index>(kParts);
  };
  parallel_for(kParts, [&](std::size_t part) { visit(part, border(part), border(part + 1)); });
}

/// The normal equations of gains and curves, without those among the gains.
struct Sums {
  Eigen::MatrixXd gram;  ///< the lower triangle
  Eigen::VectorXd right;
};

/// Those of the rows [first, end). `by_row`: gains x rows; `count`: gains and knots.
Sums sums_over(const std::vector<Curve>& curves, const Eigen::MatrixXd& by_row,
               const Eigen::VectorXd& residual_N, const Eigen::VectorXd& usable, Eigen::Index count,
               Eigen::Index first, Eigen::Index end) {
  const Eigen::Index gains = by_row.rows();
  Sums sums{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count)};
  Eigen::MatrixXd beside = Eigen::MatrixXd::Zero(gains, count);  // gains x curves
  SparseRow sparse;
  for (Eigen::Index row = first; row < end; ++row) {
    if (usable(row) == 0.0) continue;
    sparse.fill(curves, row);
    for (const auto& [column, value] : sparse.values) {
      beside.col(column) += value * by_row.col(row);
      sums.right(column) += value * residual_N(row);
      for (const auto& [other, second] : sparse.values) {
        if (other <= column) sums.gram(column, other) += value * second;
      }
    }
  }
  sums.gram.bottomLeftCorner(count - gains, gains) = beside.rightCols(count - gains).transpose();
  return sums;
}

}  // namespace

Eigen::VectorXd saturated_residual_N(const Measurement& measurement, const Linearisation& model) {
  // A delay moves the force by its derivative.
  const double step_s = measurement.tick_s();
  Eigen::MatrixXd gains(measurement.row_count(), model.columns().cols() + 1);
  gains << model.columns(), (measurement.force_N({step_s}) - measurement.force_N({-step_s})) / (2.0 * step_s);
  std::vector<Curve> curves = curves_of(measurement, model);
  Eigen::Index count = gains.cols();
  for (Curve& curve : curves) {
    curve.first_column = count;
    count += static_cast<Eigen::Index>(curve.knots.size());
  }
  const Eigen::VectorXd residual_N = model.residual_N();
  const Eigen::VectorXd& usable = measurement.row_usable();
  // A row of the gains lies apart in memory; its transpose is one column.
  const Eigen::MatrixXd by_row = (usable.asDiagonal() * gains).transpose();
  std::vector<Sums> parts(kParts);
  in_parts(residual_N.size(), [&](std::size_t part, Eigen::Index first, Eigen::Index end) {
    parts[part] = sums_over(curves, by_row, residual_N, usable, count, first, end);
  });
  for (std::size_t part = 1; part < kParts; ++part) {
    parts.front().gram += parts[part].gram;
    parts.front().right += parts[part].right;
  }
  Eigen::MatrixXd& gram = parts.front().gram;
  Eigen::VectorXd& right = parts.front().right;
  gram.topLeftCorner(gains.cols(), gains.cols()).noalias() = by_row * gains;
  right.head(gains.cols()).noalias() = by_row * residual_N;
  const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  gram = scale.asDiagonal() * gram * scale.asDiagonal();
  gram.diagonal().array() += kRidge;
  const Eigen::VectorXd solution = scale.cwiseProduct(solve_symmetric(gram, scale.cwiseProduct(right)));
  Eigen::VectorXd left_N = residual_N - gains * solution.head(gains.cols());
  in_parts(residual_N.size(), [&](std::size_t, Eigen::Index first, Eigen::Index end) {
    SparseRow sparse;
    for (Eigen::Index row = first; row < end; ++row) {
      sparse.fill(curves, row);
      for (const auto& [column, value] : sparse.values) left_N(row) -= value * solution(column);
    }
  });
  return left_N;
}

}  // namespace slipstack::workbench
