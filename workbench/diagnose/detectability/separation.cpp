// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/detectability/separation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "workbench/base/parallel.h"

namespace slipstack::workbench {

Eigen::MatrixXd weighted_columns(const Measurement& measurement, const FittedModel& base, const Term& term) {
  Eigen::MatrixXd columns;
  if (term.gains.empty()) {
    const double step_s = measurement.tick_s();
    columns = (measurement.force_N({step_s}) - measurement.force_N({-step_s})) / (2.0 * step_s);
  } else {
    columns = base.linearisation->columns_of(term);
  }
  return measurement.row_weights().cwiseSqrt().asDiagonal() * columns;
}

Eigen::VectorXd weighted_residual(const Measurement& measurement, const FittedModel& model) {
  return model.linearisation->residual_N().cwiseProduct(measurement.row_weights().cwiseSqrt());
}

ResidualMaker::ResidualMaker(const Eigen::MatrixXd& known) {
  if (known.cols() == 0) return;
  // Columns are scaled to unit length, so that the regularisation does not depend on their units.
  const Eigen::RowVectorXd length = known.colwise().norm();
  unit_ = known * length.cwiseMax(1e-150).cwiseInverse().asDiagonal();
  Eigen::MatrixXd gram = unit_.transpose() * unit_;
  gram.diagonal().array() += 1e-10;
  gram_.compute(gram);
}

Eigen::MatrixXd ResidualMaker::beyond(const Eigen::MatrixXd& columns) const {
  if (unit_.cols() == 0) return columns;
  return columns - unit_ * gram_.solve(unit_.transpose() * columns);
}

namespace {

/// The columns of the baseline whose gains are free.
std::vector<Eigen::Index> free_columns(const FittedModel& base) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < base.constraints.lower.size(); ++i) {
    if (base.constraints.lower(i) < base.constraints.upper(i)) free.push_back(i);
  }
  return free;
}

}  // namespace

Eigen::VectorXd expected_residual_N(const FittedModel& base, const Term& term) {
  if (term.gains.empty()) return Eigen::VectorXd::Zero(base.linearisation->force_N().size());
  const Eigen::MatrixXd columns = base.linearisation->columns_of(term);
  const ResidualMaker baseline(base.linearisation->columns()(Eigen::all, free_columns(base)));
  const Eigen::MatrixXd left = baseline.beyond(columns);
  return left * seen_gains(term, left);
}

Eigen::MatrixXd weighted_free_columns(const Measurement& measurement, const FittedModel& base) {
  return measurement.row_weights().cwiseSqrt().asDiagonal() *
         base.linearisation->columns()(Eigen::all, free_columns(base));
}

ResidualMaker baseline_residual_maker(const Measurement& measurement, const FittedModel& base) {
  return ResidualMaker(weighted_free_columns(measurement, base));
}

Eigen::VectorXd seen_gains(const Term& term, const Eigen::MatrixXd& beyond_base) {
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(beyond_base.cols());
  for (std::size_t i = 0; i < term.gains.size(); ++i) gains(static_cast<Eigen::Index>(i)) = term.gains[i];
  if ((beyond_base * gains).squaredNorm() > 0.0 || gains.size() == 0) return gains;
  Eigen::Index best = 0;  // of several gains the one with the largest orthogonal part
  beyond_base.colwise().squaredNorm().maxCoeff(&best);
  gains(best) = 1.0;
  return gains;
}

std::vector<Separation> separations(const Measurement& measurement, const FittedModel& base,
                                    const Terms& terms, double noise_N) {
  const ResidualMaker baseline = baseline_residual_maker(measurement, base);
  std::vector<Eigen::MatrixXd> columns(terms.size());
  std::vector<std::optional<ResidualMaker>> residual_makers(terms.size());
  parallel_for(terms.size(), [&](std::size_t i) {
    columns[i] = baseline.beyond(weighted_columns(measurement, base, terms[i]));
    residual_makers[i].emplace(columns[i]);
  });
  std::vector<Separation> all;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const Eigen::VectorXd force = columns[i] * seen_gains(terms[i], columns[i]);
    const double own = force.squaredNorm();
    for (std::size_t j = 0; j < terms.size(); ++j) {
      if (i == j) continue;
      const double left = own > 0.0 ? residual_makers[j]->beyond(force).squaredNorm() : 0.0;
      const double sine = own > 0.0 ? std::sqrt(std::clamp(left / own, 0.0, 1.0)) : 0.0;
      all.push_back({terms[i].id(), terms[j].id(), std::asin(sine) * 180.0 / std::numbers::pi,
                     left / (noise_N * noise_N)});
    }
  }
  return all;
}

}  // namespace slipstack::workbench
