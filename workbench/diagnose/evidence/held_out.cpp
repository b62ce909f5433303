// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/base/linear_systems.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/signal/repetition.h"

namespace slipstack::workbench {
namespace {

/// Calls visit(first, count, half) for every run of rows of one half.
template <class Visit>
void each_run(const Halves& halves, Visit&& visit) {
  for (std::size_t first = 0; first < halves.size();) {
    std::size_t end = first + 1;
    while (end < halves.size() && halves[end] == halves[first]) ++end;
    visit(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(end - first),
          static_cast<std::size_t>(halves[first]));
    first = end;
  }
}

/// The normal matrix with the ridge that keeps columns without rows from any value.
Eigen::MatrixXd regular(Eigen::MatrixXd normal) {
  normal.diagonal().array() += 1.0 + 1e-6 * normal.diagonal().maxCoeff();
  return normal;
}

}  // namespace

HeldOut held_out(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual, const Halves& halves) {
  const Eigen::Index count = columns.cols();
  std::array<Eigen::MatrixXd, 2> gram{Eigen::MatrixXd::Zero(count, count),
                                      Eigen::MatrixXd::Zero(count, count)};
  std::array<Eigen::VectorXd, 2> right{Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count)};
  each_run(halves, [&](Eigen::Index first, Eigen::Index rows, std::size_t half) {
    const auto part = columns.middleRows(first, rows);
    gram[half].noalias() += part.transpose() * part;
    right[half].noalias() += part.transpose() * residual.segment(first, rows);
  });
  const auto solve = [](const Eigen::MatrixXd& normal, const Eigen::VectorXd& b) {
    return solve_symmetric(regular(normal), b);
  };
  const std::array<Eigen::VectorXd, 2> value{solve(gram[0], right[0]), solve(gram[1], right[1])};
  double error = 0.0;
  each_run(halves, [&](Eigen::Index first, Eigen::Index rows, std::size_t half) {
    error +=
        (residual.segment(first, rows) - columns.middleRows(first, rows) * value[1 - half]).squaredNorm();
  });
  const double whole = std::max(residual.squaredNorm(), 1e-300);
  const Eigen::VectorXd both = solve(gram[0] + gram[1], right[0] + right[1]);
  return {1.0 - std::sqrt(error / whole), columns * both, both};
}

Eigen::VectorXd errors_of_sums(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                               const Halves& halves, const Eigen::MatrixXd& sums) {
  const Eigen::MatrixXd normal = regular(columns.transpose() * columns);
  Eigen::MatrixXd influence(sums.rows(), sums.cols());
  for (Eigen::Index i = 0; i < sums.cols(); ++i) influence.col(i) = solve_symmetric(normal, sums.col(i));
  const Eigen::VectorXd left = residual - columns * solve_symmetric(normal, columns.transpose() * residual);
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(sums.cols());
  each_run(halves, [&](Eigen::Index first, Eigen::Index rows, std::size_t) {
    const Eigen::VectorXd score = columns.middleRows(first, rows).transpose() * left.segment(first, rows);
    variance += (influence.transpose() * score).cwiseAbs2();
  });
  return variance.cwiseSqrt();
}

Halves alternating_blocks(const Measurement& measurement) {
  Halves halves(static_cast<std::size_t>(measurement.row_count()));
  std::uint8_t half = 0;
  for (const RowRange& range : block_ranges(measurement, parts_of_block(measurement))) {
    std::fill_n(halves.begin() + range.first, range.count, half);
    half = 1 - half;
  }
  return halves;
}

Eigen::VectorXd at_rows(const Measurement& measurement, const std::vector<double>& per_sample) {
  Eigen::VectorXd values(measurement.row_count());
  for (Eigen::Index row = 0; row < values.size(); ++row) {
    values(row) = per_sample[measurement.row_samples()[static_cast<std::size_t>(row)]];
  }
  return values;
}

double rows_of_period(const Measurement& measurement, const LogPart& part) {
  const Eigen::VectorXd velocity_mps = at_rows(measurement, measurement.velocity_mps());
  return repetition_period({velocity_mps.data() + part.first_row, part.row_count});
}

Eigen::VectorXd row_times(const Measurement& measurement) {
  Eigen::VectorXd times(measurement.row_count());
  for (Eigen::Index row = 0; row < times.size(); ++row) {
    times(row) = measurement.time_s(measurement.row_samples()[static_cast<std::size_t>(row)]);
  }
  return times;
}

}  // namespace slipstack::workbench
