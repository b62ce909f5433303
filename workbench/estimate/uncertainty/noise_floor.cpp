// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/noise_floor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "workbench/base/statistics.h"
#include "workbench/estimate/linear/linearisation.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/terms/slip_grid.h"
#include "workbench/estimate/uncertainty/residual_noise.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {
namespace {

/// Encoders that read the motion again. Their grids are shifted by multiples of the golden section, no border
/// of a cell on another, and each as far the other way, so that a mirrored log is judged alike. In a cell
/// that the axis stays in unseen they have it go to the far side, half-way and on, or half-way at once and
/// back, as an axis does that a controller lets unload.
/// What zigzags faster than the samples go has corners between them, beyond what is read by up to its height.
constexpr double kGoldenPart = 0.3819660112501051;
constexpr double kLow = 1.0 / 6.0;
constexpr double kHigh = 5.0 / 6.0;
constexpr std::array<EncoderRealisation, 6> kEncoderRealisations{{
    {kGoldenPart, {.places = {kHigh, kHigh}}, kLow},
    {1.0 - kGoldenPart, {.places = {kHigh, kHigh}}, kLow},
    {2.0 * kGoldenPart, {.places = {kLow, 0.5}}, 0.5},
    {1.0 - 2.0 * kGoldenPart, {.places = {kLow, 0.5}}, 0.5},
    {3.0 * kGoldenPart - 1.0, {.places = {0.5, kLow}, .at_speed = true}, kHigh},
    {2.0 - 3.0 * kGoldenPart, {.places = {0.5, kLow}, .at_speed = true}, kHigh},
}};

/// Quantisation far below what the plain model leaves anyway does not matter.
constexpr double kLeastWeighing = 0.1;

/// Rows over which the error of one reading stands for that of another: some filter lengths.
constexpr Eigen::Index kNeighbours = 12;

/// Classes of rows by what quantisation does there, and by how much less may be left of it by chance.
constexpr std::size_t kClasses = 20;
constexpr double kChance = 1.25;

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

/// Variances at the rows [N^2].
struct RowVariances {
  Eigen::VectorXd noise;         ///< of force and acceleration
  Eigen::VectorXd quantisation;  ///< what it may do to the hysteresis
  Eigen::VectorXd left;          ///< squared residual
};

/// `reading_of(i)` gives the other readings, one after another.
template <class ReadingOf>
RowVariances variances_at_rows(const Measurement& measurement, const Terms& terms, ReadingOf&& reading_of) {
  RowVariances variances{
      Eigen::VectorXd(measurement.row_count()), Eigen::VectorXd::Zero(measurement.row_count()), {}};
  const Eigen::VectorXd here = measurement.filtered(evaluate_force(measurement, terms).force_N);
  const MeasurementDynamics lag = measurement_dynamics_of(terms);
  const Eigen::VectorXd residual_N = measurement.force_N(lag) - here;
  std::vector<Eigen::VectorXd> realisations_N;
  realisations_N.reserve(kEncoderRealisations.size());
  for (std::size_t reading = 0; reading < kEncoderRealisations.size(); ++reading) {
    const Measurement& other = reading_of(reading);
    // The other reading takes the first's motion for the truth: their difference is one encoder's error.
    realisations_N.push_back(here - measurement.filtered(evaluate_force(other, terms).force_N));
  }
  const double gain = measurement.force_noise_gain(lag);
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const Interval own = measurement.parts_of_log(log);
    if (own.first == own.end) continue;
    const LogPart& first = measurement.parts()[own.first];
    double force = first.force_noise_N;
    if (!measurement.force_noise_given()) {
      LogPart all = first;  // its parts as one
      all.sample_count = measurement.parts()[own.end - 1].end_sample() - first.first_sample;
      all.row_count = static_cast<std::size_t>(measurement.rows_of_log(log).count);
      force = residual_noise(measurement, all, residual_N, realisations_N, mass_kg(terms, log), lag)
                  .bounded(force);
    }
    for (std::size_t p = own.first; p < own.end; ++p) {
      const LogPart& part = measurement.parts()[p];
      const double inertia = mass_kg(terms, log) * measurement.acceleration_noise_mps2(part);
      variances.noise
          .segment(static_cast<Eigen::Index>(part.first_row), static_cast<Eigen::Index>(part.row_count))
          .setConstant(squared(gain * force) + squared(inertia));
    }
  }
  for (const Eigen::VectorXd& reading_N : realisations_N) {
    variances.quantisation += reading_N.cwiseAbs2() / static_cast<double>(kEncoderRealisations.size());
  }
  variances.left = residual_N.cwiseAbs2();
  return variances;
}

/// The readings tell how far quantisation may lead astray; it has led no further than what is left. Judged in
/// classes of rows, since at one row both are chance: where the axis rests within a cell for long the
/// readings err by all that the cell allows, and so did the axis, unless it moved as evenly as is assumed.
Eigen::VectorXd borne_out(const RowVariances& rows, const Eigen::VectorXd& usable) {
  const Eigen::VectorXd likely = smoothed(rows.quantisation);
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
      left += rows.left(row) - rows.noise(row);
    }
    if (kChance * left >= expected || expected <= 0.0) continue;
    const double share = kChance * std::max(left, 0.0) / expected;
    for (const Eigen::Index row : members) variance(row) *= share;
  }
  return variance;
}

/// By what may be: a row that happens to be right is worth no more than its neighbours.
Eigen::VectorXd variance_to_weigh_by(const Measurement& measurement, const Terms& plain) {
  // One reading at a time: pieces are judged by many threads at once.
  const RowVariances rows = variances_at_rows(measurement, plain, [&](std::size_t reading) {
    return measurement.with_realisation(kEncoderRealisations[reading]);
  });
  return smoothed(rows.noise + rows.quantisation);
}

}  // namespace

std::vector<Measurement> encoder_realisations(const Measurement& measurement) {
  std::vector<Measurement> readings;
  readings.reserve(kEncoderRealisations.size());
  for (const EncoderRealisation& other : kEncoderRealisations) {
    readings.push_back(measurement.with_realisation({.shift_steps = other.shift_steps}));
  }
  return readings;
}

NoiseFloor::NoiseFloor(const Measurement& measurement) : measurement_(measurement) {
  realisations_.reserve(kEncoderRealisations.size());
  for (const EncoderRealisation& other : kEncoderRealisations)
    realisations_.push_back(measurement.with_realisation(other));
}

Eigen::VectorXd NoiseFloor::variance(const Terms& terms) const {
  const RowVariances rows =
      variances_at_rows(measurement_, terms,
                        [this](std::size_t reading) -> const Measurement& { return realisations_[reading]; });
  return rows.noise + borne_out(rows, measurement_.row_usable());
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
  const FittedModel plain = fit_effects(measurement, default_baseline(), {});
  if (const Term* hysteresis = find_role(plain.terms, Role::hysteresis)) {
    measurement.set_slip_distances(refined_slip_distances(*hysteresis, measurement.encoder_resolution_m()));
  }
  const Eigen::VectorXd variance = variance_to_weigh_by(measurement, plain.terms);
  const double least = variance.minCoeff();
  const double enough = std::max({least, squared(kLeastWeighing * plain.train_rmse_N), 1e-300});
  RowWeighing weighing{plain.terms, least, enough};
  measurement.set_row_weights(weighing.weights(variance));
  return weighing;
}

Eigen::VectorXd RowWeighing::weights(const Eigen::VectorXd& variance) const {
  return (enough / (enough + (variance.array() - least).max(0.0))).matrix();
}

void RowWeighing::apply(Measurement& piece) const {
  if (piece.row_count() == 0) return;
  piece.set_row_weights(weights(variance_to_weigh_by(piece, plain)));
}

}  // namespace slipstack::workbench
