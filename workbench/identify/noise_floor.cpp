// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/noise_floor.h"

#include <algorithm>
#include <cmath>

#include "workbench/identify/fit.h"
#include "workbench/identify/linearisation.h"

namespace slipstack::workbench {
namespace {

/// Encoders that read the motion again, their grids shifted by multiples of the golden section: no border of
/// a cell falls on another.
constexpr int kReadings = 3;
constexpr double kGoldenPart = 0.3819660112501051;

/// Quantisation far below what the plain model leaves anyway does not matter.
constexpr double kWorthWeighing = 0.1;

/// Rows over which the error of one reading stands for that of another: some filter lengths.
constexpr Eigen::Index kNeighbours = 12;

double squared(double x) {
  return x * x;
}

/// Mean over the neighbours, by a running sum.
Eigen::VectorXd smoothed(const Eigen::VectorXd& values) {
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

}  // namespace

NoiseFloor::NoiseFloor(const Measurement& measurement) : measurement_(measurement) {
  for (int reading = 1; reading <= kReadings; ++reading) {
    shifted_.push_back(measurement.requantised(std::fmod(kGoldenPart * reading, 1.0)));
  }
}

Eigen::VectorXd NoiseFloor::variance(const Terms& terms) const {
  Eigen::VectorXd sum(measurement_.row_count());
  for (std::size_t p = 0; p < measurement_.parts().size(); ++p) {
    const LogPart& part = measurement_.parts()[p];
    const double force = measurement_.filtered_force_noise_N(part);
    const double inertia = mass_kg(terms, p) * measurement_.acceleration_noise_mps2(part);
    sum.segment(static_cast<Eigen::Index>(part.first_row), static_cast<Eigen::Index>(part.row_count))
        .setConstant(force * force + inertia * inertia);
  }
  const Eigen::VectorXd here = measurement_.filtered(evaluate_force(measurement_, terms).force_N);
  for (const Measurement& shifted : shifted_) {
    // The other reading takes the first's motion for the truth: their difference is one encoder's error.
    const Eigen::VectorXd there = measurement_.filtered(evaluate_force(shifted, terms).force_N);
    sum += (here - there).cwiseAbs2() / kReadings;
  }
  return sum;
}

double NoiseFloor::of(const Terms& terms) const {
  const Eigen::VectorXd& weights = measurement_.row_weights();
  return std::sqrt(weights.dot(variance(terms)) / weights.sum());
}

std::vector<double> NoiseFloor::of_each_log(const Terms& terms) const {
  const Eigen::VectorXd rows = variance(terms);
  std::vector<double> floors;
  floors.reserve(measurement_.parts().size());
  for (const LogPart& part : measurement_.parts()) {
    const auto first = static_cast<Eigen::Index>(part.first_row);
    const auto count = static_cast<Eigen::Index>(part.row_count);
    const Eigen::VectorXd weights = measurement_.row_weights().segment(first, count);
    floors.push_back(std::sqrt(weights.dot(rows.segment(first, count)) / weights.sum()));
  }
  return floors;
}

void weigh_rows(Measurement& measurement) {
  const FittedModel plain = fit_effects(measurement, {"inertia", "presliding_hysteresis"}, {});
  const Eigen::VectorXd variance = smoothed(NoiseFloor(measurement).variance(plain.terms));
  const double least = variance.minCoeff();
  const double enough = std::max({least, squared(kWorthWeighing * plain.train_rmse_N), 1e-300});
  measurement.set_row_weights((enough / (enough + variance.array() - least)).matrix());
}

}  // namespace slipstack::workbench
