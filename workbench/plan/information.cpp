// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/information.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "workbench/base/linear_systems.h"
#include "workbench/diagnose/detectability/separation.h"

namespace slipstack::workbench {
namespace {

std::vector<Eigen::Index> run(Eigen::Index first, Eigen::Index count) {
  std::vector<Eigen::Index> indices;
  for (Eigen::Index i = 0; i < count; ++i) indices.push_back(first + i);
  return indices;
}

}  // namespace

std::vector<Information> Information::of(const Measurement& measurement, const FittedModel& base,
                                         const std::vector<Expected>& effects, const std::vector<int>& groups,
                                         int group_count, const ResidualScale& scatter) {
  Information layout;
  std::vector<Eigen::MatrixXd> parts;
  Eigen::Index next = 0;
  const auto append = [&](Eigen::MatrixXd columns) {
    std::vector<Eigen::Index> indices = run(next, columns.cols());
    next += columns.cols();
    parts.push_back(std::move(columns));
    return indices;
  };
  layout.base_ = append(weighted_free_columns(measurement, base));
  for (const Expected& effect : effects) {
    const Eigen::MatrixXd own = weighted_columns(measurement, base, effect.term);
    Eigen::VectorXd gains = Eigen::VectorXd::Ones(own.cols());
    for (std::size_t g = 0; g < effect.term.gains.size(); ++g) {
      gains(static_cast<Eigen::Index>(g)) = effect.term.gains[g];
    }
    layout.force_.push_back(append(own * gains).front());
    std::vector<Eigen::Index> spanned = append(own);
    for (const std::vector<double>& shapes : effect.alternatives) {
      Term other = effect.term;
      other.shapes = shapes;
      const std::vector<Eigen::Index> more = append(weighted_columns(measurement, base, other));
      spanned.insert(spanned.end(), more.begin(), more.end());
    }
    layout.spanned_.push_back(std::move(spanned));
  }
  const double unit_N = scatter.rms_N * std::sqrt(scatter.inflation);
  layout.gram_ = Eigen::MatrixXd::Zero(next, next);
  std::vector<Information> all(static_cast<std::size_t>(group_count), layout);
  // Rows of one group are consecutive: one product for each run.
  const Eigen::Index rows = measurement.row_count();
  for (Eigen::Index first = 0; first < rows;) {
    const int group = groups[static_cast<std::size_t>(first)];
    Eigen::Index end = first + 1;
    while (end < rows && groups[static_cast<std::size_t>(end)] == group) ++end;
    if (group >= 0) {
      Eigen::MatrixXd block(end - first, next);
      Eigen::Index at = 0;
      for (const Eigen::MatrixXd& part : parts) {
        block.middleCols(at, part.cols()) = part.middleRows(first, end - first) / unit_N;
        at += part.cols();
      }
      Information& own = all[static_cast<std::size_t>(group)];
      own.gram_ += block.transpose() * block;
      own.rows_ += measurement.row_weights().segment(first, end - first).sum() / scatter.inflation;
    }
    first = end;
  }
  return all;
}

void Information::add(const Information& other) {
  gram_ += other.gram_;
  rows_ += other.rows_;
}

void Information::repeat(double times) {
  gram_ *= times;
  rows_ *= times;
}

double Information::unexplained(std::size_t i, const std::vector<Eigen::Index>& known) const {
  const double own = gram_(force_[i], force_[i]);
  std::vector<Eigen::Index> excited;
  for (const Eigen::Index column : known) {
    if (gram_(column, column) > 0.0) excited.push_back(column);
  }
  if (excited.empty() || own <= 0.0) return own;
  Eigen::MatrixXd normal = gram_(excited, excited);
  Eigen::VectorXd right = gram_(excited, force_[i]);
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  normal = scale.asDiagonal() * normal * scale.asDiagonal();
  right = scale.cwiseProduct(right);
  // The ridge treats columns that hardly differ as one: the direction between them is not excited.
  normal.diagonal().array() += 1e-9;
  return std::max(0.0, own - right.dot(solve_symmetric(normal, right)));
}

Information::Figure Information::alone(std::size_t i) const {
  return {unexplained(i, base_), 90.0, rows_};
}

Information::Figure Information::against(std::size_t i, std::size_t j) const {
  std::vector<Eigen::Index> known = base_;
  known.insert(known.end(), spanned_[j].begin(), spanned_[j].end());
  const double own = unexplained(i, base_);
  const double left = unexplained(i, known);
  const double sine = own > 0.0 ? std::sqrt(std::clamp(left / own, 0.0, 1.0)) : 0.0;
  return {left, std::asin(sine) * 180.0 / std::numbers::pi, rows_};
}

}  // namespace slipstack::workbench
