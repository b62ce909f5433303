// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/noise_floor.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "workbench/base/statistics.h"
#include "workbench/estimate/uncertainty/residual_noise.h"
#include "workbench/estimate/uncertainty/saturated_residual.h"

namespace slipstack::workbench {
namespace {

/// Rows to either side over which the variance by quantisation is averaged: some filter lengths.
constexpr Eigen::Index kNeighbours = 12;

/// Number of classes of rows, by their variance by quantisation; and the factor by which the residual of a
/// class may fall short of that variance by chance. Chosen.
constexpr std::size_t kClasses = 20;
constexpr double kChance = 1.25;
/// Relative to the largest variance by quantisation, what rounding leaves where there is none.
constexpr double kNothing = 1e-9;

/// The parts of one log as one.
LogPart whole_of_log(const Measurement& measurement, std::size_t log) {
  const Interval own = measurement.parts_of_log(log);
  LogPart all = measurement.parts()[own.first];
  all.sample_count = measurement.parts()[own.end - 1].end_sample() - all.first_sample;
  all.row_count = static_cast<std::size_t>(measurement.rows_of_log(log).count);
  return all;
}

/// Calls visit(log, its parts as one) for each log of which the measurement has any part.
template <class Visit>
void each_log(const Measurement& measurement, Visit&& visit) {
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const Interval own = measurement.parts_of_log(log);
    if (own.first != own.end) visit(log, whole_of_log(measurement, log));
  }
}

/// The variance by quantisation, as far as it is supported by the residual. The realisations show how large
/// the error may be, but it cannot have been larger than the residual. They are compared in classes of rows,
/// since the values at a single row are random. Where the axis stands within a cell for long, the
/// realisations differ by the whole cell, although the axis may have moved as evenly as the interpolation
/// assumes.
Eigen::VectorXd supported_variance(const RowVariances& rows, const Eigen::VectorXd& left_N,
                                   const Eigen::VectorXd& usable) {
  // Rows without any quantisation are equal but for rounding, which must not sort them.
  const Eigen::VectorXd smooth = smoothed(rows.quantisation);
  const Eigen::VectorXd likely = smooth.cwiseMax(kNothing * smooth.maxCoeff());
  std::vector<Eigen::Index> order;
  for (Eigen::Index row = 0; row < likely.size(); ++row) {
    if (usable(row) > 0.0) order.push_back(row);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return likely(a) < likely(b); });
  Eigen::VectorXd variance = rows.quantisation;
  for (std::size_t c = 0; c < kClasses; ++c) {
    const std::size_t first = c * order.size() / kClasses;
    const std::size_t end = (c + 1) * order.size() / kClasses;
    const auto members = std::span(order).subspan(first, end - first);
    double expected = 0.0;
    double left = 0.0;
    for (const Eigen::Index row : members) {
      expected += rows.quantisation(row);
      left += squared(left_N(row)) - rows.noise(row);
    }
    if (kChance * left >= expected || expected <= 0.0) continue;
    const double share = kChance * std::max(left, 0.0) / expected;
    for (const Eigen::Index row : members) variance(row) *= share;
  }
  return variance;
}

}  // namespace

Eigen::VectorXd smoothed(const Eigen::VectorXd& values) {
  // By differences of a cumulative sum.
  Eigen::VectorXd sums(values.size() + 1);
  sums(0) = 0.0;
  for (Eigen::Index i = 0; i < values.size(); ++i) sums(i + 1) = sums(i) + values(i);
  Eigen::VectorXd means(values.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const Eigen::Index first = std::max<Eigen::Index>(0, i - kNeighbours);
    const Eigen::Index last = std::min(values.size(), i + kNeighbours + 1);
    means(i) = (sums(last) - sums(first)) / static_cast<double>(last - first);
  }
  return means;
}

RowVariances variances_at_rows(const Measurement& measurement, const std::vector<double>& mass_kg,
                               const std::vector<double>& force_noise_N, const ForceChanges& changes_N) {
  RowVariances variances{Eigen::VectorXd(measurement.row_count()),
                         Eigen::VectorXd::Zero(measurement.row_count())};
  const double gain = measurement.force_noise_gain({});
  for (const LogPart& part : measurement.parts()) {
    const double inertia_N = mass_kg[part.log] * measurement.acceleration_noise_mps2(part);
    variances.noise
        .segment(static_cast<Eigen::Index>(part.first_row), static_cast<Eigen::Index>(part.row_count))
        .setConstant(squared(gain * force_noise_N[part.log]) + squared(inertia_N));
  }
  for (const Eigen::VectorXd& change_N : changes_N) {
    variances.quantisation += change_N.cwiseAbs2() / static_cast<double>(changes_N.size());
  }
  return variances;
}

std::vector<double> force_noise_of_logs_N(const Measurement& measurement, const std::vector<double>& mass_kg,
                                          const Eigen::VectorXd& saturated_N, const ForceChanges& changes_N) {
  std::vector<double> noise_N(measurement.log_count(), 0.0);
  each_log(measurement, [&](std::size_t log, const LogPart& all) {
    noise_N[log] = all.force_noise_N;
    if (measurement.force_noise_given()) return;
    noise_N[log] =
        residual_noise(measurement, all, saturated_N, changes_N, mass_kg[log]).bounded(noise_N[log]);
  });
  return noise_N;
}

Eigen::VectorXd unexplainable_variance(const RowVariances& rows, const Eigen::VectorXd& saturated_N,
                                       const Eigen::VectorXd& usable) {
  return rows.noise + supported_variance(rows, saturated_N, usable);
}

void lower_noise_floor(Measurement& measurement, const Linearisation& model) {
  const Measurement::NoiseReadings* const readings = measurement.noise_readings();
  if (readings == nullptr) return;
  const Eigen::VectorXd saturated_N = saturated_residual_N(measurement, model);
  const std::vector<double> force_noise_N =
      force_noise_of_logs_N(measurement, readings->mass_kg, saturated_N, readings->changes_N);
  Eigen::VectorXd variance = unexplainable_variance(
      variances_at_rows(measurement, readings->mass_kg, force_noise_N, readings->changes_N), saturated_N,
      measurement.row_usable());
  const Eigen::VectorXd& weights = measurement.row_weights();
  if (weights.dot(variance) < weights.dot(measurement.noise_variance()))
    measurement.set_noise_variance(std::move(variance));
}

void bound_noise_floor(Measurement& measurement, double left_N) {
  const double floor_N = measurement.noise_floor_N();
  if (left_N < floor_N)
    measurement.set_noise_variance(measurement.noise_variance() * squared(left_N / floor_N));
}

void lower_noise_floor(Measurement& measurement, const Linearisation& model, double left_N) {
  lower_noise_floor(measurement, model);
  bound_noise_floor(measurement, left_N);
}

}  // namespace slipstack::workbench
