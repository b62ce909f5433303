// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/robust.h"

#include <algorithm>
#include <cmath>

#include "workbench/base/statistics.h"

namespace slipstack::workbench {
namespace {

constexpr double kHuber = 5.0;  ///< limit in robust standard deviations: Gaussian residuals do not reach it
constexpr int kIterations = 5;
constexpr double kConverged = 1e-3;  ///< relative change of the sum of weights that ends the iteration
/// A larger share of rows beyond the limit is not outliers but a distribution with heavy tails. Chosen.
constexpr double kMostOutliers = 0.05;

double robust_deviation(const Eigen::VectorXd& residual, const Eigen::VectorXd& weights) {
  std::vector<double> magnitudes;
  magnitudes.reserve(static_cast<std::size_t>(residual.size()));
  for (Eigen::Index row = 0; row < residual.size(); ++row) {
    if (weights(row) > 0.0) magnitudes.push_back(std::abs(residual(row)));
  }
  return magnitudes.empty() ? 0.0 : median(std::move(magnitudes)) / kMedianOfNormal;
}

}  // namespace

Eigen::VectorXd huber_weights(const Eigen::VectorXd& plain, const Eigen::VectorXd& residual_N,
                              double limit_N) {
  const Eigen::ArrayXd magnitude = residual_N.cwiseProduct(plain.cwiseSqrt()).array().abs();
  return plain.array() * (limit_N / magnitude.max(std::max(limit_N, 1e-300)));
}

RobustFit fit_robustly(Measurement& measurement, FittedModel fitted) {
  RobustFit robust{std::move(fitted), 0, 0.0};
  const Eigen::VectorXd plain = measurement.row_weights();
  double sum = plain.sum();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::VectorXd residual = robust.model.linearisation->residual_N().cwiseProduct(plain.cwiseSqrt());
    const double limit = kHuber * robust_deviation(residual, plain);
    const Eigen::VectorXd weights = huber_weights(plain, robust.model.linearisation->residual_N(), limit);
    const Eigen::Index outliers = (residual.array().abs() > limit).count();
    if (static_cast<double>(outliers) > kMostOutliers * static_cast<double>(residual.size())) break;
    robust.limit_N = limit;
    if (outliers == 0) break;
    robust.outliers = outliers;
    Eigen::Index first = 0;
    (residual.array().abs() > limit).cast<int>().maxCoeff(&first);
    robust.first_s = measurement.sample(measurement.row_samples()[static_cast<std::size_t>(first)]).time_s;
    measurement.set_fit_weights(weights);
    robust.model = fit_gains(measurement, robust.model.terms);
    const double now = weights.sum();
    const bool converged = std::abs(now - sum) <= kConverged * sum;
    sum = now;
    if (converged) break;
  }
  return robust;
}

}  // namespace slipstack::workbench
