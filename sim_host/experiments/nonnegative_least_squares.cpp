// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/nonnegative_least_squares.h"

#include <Eigen/QR>
#include <cmath>
#include <stdexcept>

namespace slipstack::sim {
namespace {

/// The problem behind its QR: square, few rows.
struct Small {
  Eigen::MatrixXd columns;
  Eigen::VectorXd target;
  Eigen::VectorXd scale;  // 1 / length of the original column; 0 for a column of zeros
};

Small reduced(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target) {
  const Eigen::Index count = columns.cols();
  Small small;
  small.scale = columns.colwise().norm().transpose().unaryExpr(
      [](double length) { return length > 0.0 ? 1.0 / length : 0.0; });
  Eigen::MatrixXd joined(columns.rows(), count + 1);
  joined << columns * small.scale.asDiagonal(), target;
  if (joined.rows() > joined.cols()) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(joined);
    joined = Eigen::MatrixXd(qr.matrixQR().topRows(count + 1).triangularView<Eigen::Upper>());
  }
  small.columns = joined.leftCols(count);
  small.target = joined.col(count);
  return small;
}

/// Unconstrained least squares on the passive columns; zero elsewhere.
Eigen::VectorXd solve_passive(const Small& small, const std::vector<bool>& passive) {
  std::vector<Eigen::Index> index;
  for (std::size_t i = 0; i < passive.size(); ++i) {
    if (passive[i]) index.push_back(static_cast<Eigen::Index>(i));
  }
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(small.columns.cols());
  if (index.empty()) return gains;
  const Eigen::MatrixXd chosen = small.columns(Eigen::all, index);
  gains(index) = chosen.colPivHouseholderQr().solve(small.target);
  return gains;
}

/// The bound column whose release lowers the error fastest; −1 when none does.
Eigen::Index most_promising(const Small& small, const Eigen::VectorXd& gains,
                            const std::vector<bool>& passive) {
  const Eigen::VectorXd slope = small.columns.transpose() * (small.target - small.columns * gains);
  const double least = 1e-12 * small.target.norm();
  Eigen::Index best = -1;
  for (Eigen::Index i = 0; i < slope.size(); ++i) {
    if (passive[static_cast<std::size_t>(i)] || slope[i] <= least) continue;
    if (best < 0 || slope[i] > slope[best]) best = i;
  }
  return best;
}

/// Goes from `gains` towards the passive solution and drops every gain that would turn negative.
void settle(const Small& small, const std::vector<bool>& free, std::vector<bool>& passive,
            Eigen::VectorXd& gains) {
  for (std::size_t round = 0; round <= passive.size(); ++round) {
    const Eigen::VectorXd wish = solve_passive(small, passive);
    double share = 1.0;
    Eigen::Index first = -1;
    for (Eigen::Index i = 0; i < wish.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (!passive[at] || free[at] || wish[i] > 0.0) continue;
      const double reach = gains[i] / (gains[i] - wish[i]);
      if (first < 0 || reach < share) {
        share = std::isfinite(reach) ? reach : 0.0;
        first = i;
      }
    }
    if (first < 0) {
      gains = wish;
      return;
    }
    gains += share * (wish - gains);
    for (Eigen::Index i = 0; i < gains.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (passive[at] && !free[at] && (i == first || gains[i] <= 0.0)) {
        passive[at] = false;
        gains[i] = 0.0;
      }
    }
  }
}

}  // namespace

NonnegativeFit nonnegative_least_squares(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target,
                                         const std::vector<bool>& free) {
  const auto count = static_cast<std::size_t>(columns.cols());
  if (columns.rows() != target.size() || (!free.empty() && free.size() != count)) {
    throw std::invalid_argument("least squares: sizes of columns, target and marks do not match");
  }
  const Small small = reduced(columns, target);
  const std::vector<bool> unbounded = free.empty() ? std::vector<bool>(count, false) : free;
  std::vector<bool> passive(count, false);
  for (std::size_t i = 0; i < count; ++i) {
    passive[i] = unbounded[i] && small.scale[static_cast<Eigen::Index>(i)] > 0.0;
  }
  Eigen::VectorXd gains = solve_passive(small, passive);
  // Lawson and Hanson end after finitely many rounds; rounding on columns that are nearly alike might not.
  for (std::size_t round = 0; round < 3 * count + 10; ++round) {
    const Eigen::Index next = most_promising(small, gains, passive);
    if (next < 0) break;
    passive[static_cast<std::size_t>(next)] = true;
    settle(small, unbounded, passive, gains);
  }
  NonnegativeFit fit;
  fit.residual_norm = (small.columns * gains - small.target).norm();
  fit.gains = small.scale.cwiseProduct(gains);
  return fit;
}

}  // namespace slipstack::sim
