// SPDX-License-Identifier: Apache-2.0
#include "workbench/identify/noise_floor.h"

#include <algorithm>
#include <cmath>

#include "workbench/identify/fit.h"
#include "workbench/identify/linearisation.h"
#include "workbench/identify/residual_noise.h"
#include "workbench/identify/slip_grid.h"
#include "workbench/identify/zero_phase.h"

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

Measurement read_again(const Measurement& measurement, int reading) {
  return measurement.requantised(std::fmod(kGoldenPart * (reading + 1), 1.0));
}

/// See NoiseFloor; `reading_of(i)` gives the other readings, one after another.
template <class ReadingOf>
Eigen::VectorXd variance_at_rows(const Measurement& measurement, const Terms& terms, ReadingOf&& reading_of) {
  Eigen::VectorXd sum(measurement.row_count());
  const Eigen::VectorXd here = measurement.filtered(evaluate_force(measurement, terms).force_N);
  const Eigen::VectorXd residual_N = measurement.force_N(delay_s(terms)) - here;
  std::vector<Eigen::VectorXd> readings_N;
  readings_N.reserve(kReadings);
  for (int reading = 0; reading < kReadings; ++reading) {
    const Measurement& shifted = reading_of(reading);
    // The other reading takes the first's motion for the truth: their difference is one encoder's error.
    readings_N.push_back(here - measurement.filtered(evaluate_force(shifted, terms).force_N));
  }
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const Stretch own = measurement.parts_of_log(log);
    if (own.first == own.end) continue;
    const LogPart& first = measurement.parts()[own.first];
    double force = measurement.filtered_force_noise_N(first);
    if (!measurement.force_noise_given()) {
      LogPart all = first;  // its parts as one
      all.sample_count = measurement.parts()[own.end - 1].end_sample() - first.first_sample;
      all.row_count = static_cast<std::size_t>(measurement.rows_of_log(log).count);
      const double seen_N = residual_noise_N(measurement, all, residual_N, readings_N, mass_kg(terms, log));
      force = std::max(force, seen_N * std::sqrt(noise_gain(measurement.filter().taps())));
    }
    for (std::size_t p = own.first; p < own.end; ++p) {
      const LogPart& part = measurement.parts()[p];
      const double inertia = mass_kg(terms, log) * measurement.acceleration_noise_mps2(part);
      sum.segment(static_cast<Eigen::Index>(part.first_row), static_cast<Eigen::Index>(part.row_count))
          .setConstant(force * force + inertia * inertia);
    }
  }
  for (const Eigen::VectorXd& reading_N : readings_N) sum += reading_N.cwiseAbs2() / kReadings;
  return sum;
}

}  // namespace

std::vector<Measurement> other_readings(const Measurement& measurement) {
  std::vector<Measurement> readings;
  readings.reserve(kReadings);
  for (int reading = 0; reading < kReadings; ++reading) readings.push_back(read_again(measurement, reading));
  return readings;
}

NoiseFloor::NoiseFloor(const Measurement& measurement)
    : measurement_(measurement), shifted_(other_readings(measurement)) {}

Eigen::VectorXd NoiseFloor::variance(const Terms& terms) const {
  return variance_at_rows(measurement_, terms, [this](int reading) -> const Measurement& {
    return shifted_[static_cast<std::size_t>(reading)];
  });
}

double NoiseFloor::of(const Terms& terms) const {
  const Eigen::VectorXd& weights = measurement_.row_weights();
  return std::sqrt(weights.dot(variance(terms)) / weights.sum());
}

std::vector<double> NoiseFloor::of_each_log(const Terms& terms) const {
  const Eigen::VectorXd rows = variance(terms);
  std::vector<double> floors;
  floors.reserve(measurement_.log_count());
  for (std::size_t log = 0; log < measurement_.log_count(); ++log) {
    const RowRange own = measurement_.rows_of_log(log);
    const Eigen::VectorXd weights = measurement_.row_weights().segment(own.first, own.count);
    floors.push_back(std::sqrt(weights.dot(rows.segment(own.first, own.count)) / weights.sum()));
  }
  return floors;
}

RowWeighing weigh_rows(Measurement& measurement) {
  const FittedModel plain = fit_effects(measurement, {"inertia", "presliding_hysteresis"}, {});
  if (const Term* hysteresis = find_term(plain.terms, "presliding_hysteresis")) {
    measurement.set_slip_distances(refined_slip_distances(*hysteresis, measurement.encoder_resolution_m()));
  }
  const Eigen::VectorXd variance = smoothed(NoiseFloor(measurement).variance(plain.terms));
  const double least = variance.minCoeff();
  const double enough = std::max({least, squared(kWorthWeighing * plain.train_rmse_N), 1e-300});
  RowWeighing weighing{plain.terms, least, enough};
  measurement.set_row_weights(weighing.weights(variance));
  return weighing;
}

Eigen::VectorXd RowWeighing::weights(const Eigen::VectorXd& variance) const {
  return (enough / (enough + (variance.array() - least).max(0.0))).matrix();
}

void RowWeighing::apply(Measurement& piece) const {
  if (piece.row_count() == 0) return;
  // One reading at a time: pieces are judged by many threads at once.
  piece.set_row_weights(weights(
      smoothed(variance_at_rows(piece, plain, [&](int reading) { return read_again(piece, reading); }))));
}

}  // namespace slipstack::workbench
