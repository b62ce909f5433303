// SPDX-License-Identifier: Apache-2.0
#include "workbench/signal/free_curve.h"

#include <algorithm>

namespace slipstack::workbench {

std::vector<double> knots_over(const Eigen::VectorXd& coordinate, int intervals) {
  std::vector<double> sorted(coordinate.begin(), coordinate.end());
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> knots;
  for (int k = 0; k <= intervals; ++k) {
    const double t = static_cast<double>(k) / intervals;
    const double by_rank = sorted[static_cast<std::size_t>(t * static_cast<double>(sorted.size() - 1))];
    const double by_range = sorted.front() + t * (sorted.back() - sorted.front());
    knots.push_back(0.5 * (by_rank + by_range));
  }
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
  return knots;
}

HatWeights hat_weights(double value, const std::vector<double>& knots) {
  const auto above =
      static_cast<std::size_t>(std::upper_bound(knots.begin(), knots.end(), value) - knots.begin());
  if (above == 0) return {};
  if (above == knots.size()) return {knots.size() - 1, {1.0, 0.0}};
  const double t = (value - knots[above - 1]) / (knots[above] - knots[above - 1]);
  return {above - 1, {1.0 - t, t}};
}

Eigen::MatrixXd hat_functions(const Eigen::VectorXd& coordinate, const std::vector<double>& knots) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(coordinate.size(), static_cast<Eigen::Index>(knots.size()));
  for (Eigen::Index row = 0; row < coordinate.size(); ++row) {
    const HatWeights hats = hat_weights(coordinate(row), knots);
    for (std::size_t i = 0; i < hats.weight.size(); ++i) {
      if (hats.weight[i] != 0.0) columns(row, static_cast<Eigen::Index>(hats.below + i)) = hats.weight[i];
    }
  }
  return columns;
}

}  // namespace slipstack::workbench
