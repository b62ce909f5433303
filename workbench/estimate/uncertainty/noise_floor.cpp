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

/// Realisations of the encoder's quantisation. The grids are shifted by multiples of the golden section, so
/// that no two borders coincide, and by the same shifts in the opposite direction, so that a mirrored log
/// gives the same result. While the reading does not change, the axis is assumed to move within the cell: to
/// the far side, half-way and on, or half-way at once and back, as it does when a controller unloads it. A
/// zigzag faster than the sampling has corners between the samples, which exceed the readings by up to its
/// height (beyond_corners).
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

/// Quantisation below this fraction of the plain model's residual does not lower a row's weight by half.
/// Chosen.
constexpr double kLeastWeighing = 0.1;

/// Rows to either side over which the variance by quantisation is averaged: some filter lengths.
constexpr Eigen::Index kNeighbours = 12;

/// Number of classes of rows, by their variance by quantisation; and the factor by which the residual of a
/// class may fall short of that variance by chance. Chosen.
constexpr std::size_t kClasses = 20;
constexpr double kChance = 1.25;
/// Relative to the largest variance by quantisation, what rounding leaves where there is none.
constexpr double kNothing = 1e-9;

/// Moving average over the neighbours, by differences of a cumulative sum.
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
  Eigen::VectorXd quantisation;  ///< of the hysteresis force, by quantisation
  Eigen::VectorXd left;          ///< squared residual
};

/// What a force changes by with its dry friction: the realisations have the displacement of their own, which
/// moves the hysteresis alone.
std::vector<double> dry_difference(const ForceTrace& here, const DryTrace& there) {
  std::vector<double> difference_N(here.dry_N.size());
  for (std::size_t i = 0; i < difference_N.size(); ++i) {
    difference_N[i] =
        (here.dry_N[i] * factor_at(here.dry_factor, i) - there.dry_N[i] * factor_at(there.dry_factor, i)) *
        factor_at(here.total_factor, i);
  }
  return difference_N;
}

/// `realisation_of(i)` returns the measurement with the i-th realisation; it is called once for each, in
/// order.
template <class RealisationOf>
RowVariances variances_at_rows(const Measurement& measurement, const Terms& terms,
                               RealisationOf&& realisation_of) {
  RowVariances variances{
      Eigen::VectorXd(measurement.row_count()), Eigen::VectorXd::Zero(measurement.row_count()), {}};
  const ForceTrace here = evaluate_force(measurement, terms);
  const MeasurementDynamics lag = measurement_dynamics_of(terms);
  const Eigen::VectorXd residual_N = measurement.force_N(lag) - measurement.filtered(here.force_N);
  std::vector<Eigen::VectorXd> realisations_N;
  realisations_N.reserve(kEncoderRealisations.size());
  for (std::size_t i = 0; i < kEncoderRealisations.size(); ++i) {
    // A realisation quantises the recorded motion again, so the difference of the forces is the error of one
    // encoder.
    realisations_N.push_back(
        measurement.filtered(dry_difference(here, evaluate_dry(realisation_of(i), terms))));
  }
  const double gain = measurement.force_noise_gain(lag);
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const Interval own = measurement.parts_of_log(log);
    if (own.first == own.end) continue;
    const LogPart& first = measurement.parts()[own.first];
    double force = first.force_noise_N;
    if (!measurement.force_noise_given()) {
      LogPart all = first;  // the parts of the log as one
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
  for (const Eigen::VectorXd& realisation_N : realisations_N) {
    variances.quantisation += realisation_N.cwiseAbs2() / static_cast<double>(kEncoderRealisations.size());
  }
  variances.left = residual_N.cwiseAbs2();
  return variances;
}

/// The variance by quantisation, as far as it is supported by the residual. The realisations show how large
/// the error may be, but it cannot have been larger than the residual. They are compared in classes of rows,
/// since the values at a single row are random. Where the axis stands within a cell for long, the
/// realisations differ by the whole cell, although the axis may have moved as evenly as the interpolation
/// assumes.
Eigen::VectorXd supported_variance(const RowVariances& rows, const Eigen::VectorXd& usable) {
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
      left += rows.left(row) - rows.noise(row);
    }
    if (kChance * left >= expected || expected <= 0.0) continue;
    const double share = kChance * std::max(left, 0.0) / expected;
    for (const Eigen::Index row : members) variance(row) *= share;
  }
  return variance;
}

/// Variance for the row weights: averaged, since a row whose error happens to be small is no more reliable
/// than its neighbours.
Eigen::VectorXd variance_to_weigh_by(const Measurement& measurement, const Terms& plain) {
  // One realisation in memory at a time, since many threads weigh chunks at once.
  const RowVariances rows = variances_at_rows(measurement, plain, [&](std::size_t i) {
    return measurement.with_realisation(kEncoderRealisations[i]);
  });
  return smoothed(rows.noise + rows.quantisation);
}

}  // namespace

std::vector<Measurement> encoder_realisations(const Measurement& measurement) {
  std::vector<Measurement> realisations;
  realisations.reserve(kEncoderRealisations.size());
  for (const EncoderRealisation& other : kEncoderRealisations) {
    realisations.push_back(measurement.with_realisation({.shift_steps = other.shift_steps}));
  }
  return realisations;
}

NoiseFloor::NoiseFloor(const Measurement& measurement) : measurement_(measurement) {
  realisations_.reserve(kEncoderRealisations.size());
  for (const EncoderRealisation& other : kEncoderRealisations)
    realisations_.push_back(measurement.with_realisation(other));
}

Eigen::VectorXd NoiseFloor::variance(const Terms& terms) const {
  const RowVariances rows = variances_at_rows(
      measurement_, terms, [this](std::size_t i) -> const Measurement& { return realisations_[i]; });
  return rows.noise + supported_variance(rows, measurement_.row_usable());
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

void RowWeighing::apply(Measurement& chunk) const {
  if (chunk.row_count() == 0) return;
  chunk.set_row_weights(weights(variance_to_weigh_by(chunk, plain)));
}

}  // namespace slipstack::workbench
