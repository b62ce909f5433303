// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/noise_floor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "workbench/base/statistics.h"
#include "workbench/estimate/linear/linearisation.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/terms/slip_grid.h"
#include "workbench/estimate/uncertainty/residual_noise.h"
#include "workbench/estimate/uncertainty/saturated_residual.h"
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

/// The change of the force at the rows with each realisation of the encoder. A realisation quantises the
/// recorded motion again, so the difference of the forces is the error of one encoder. One of them is in
/// memory at a time, since many threads weigh chunks at once.
std::vector<Eigen::VectorXd> changes_by_quantisation_N(const Measurement& measurement, const Terms& terms) {
  const ForceTrace here = evaluate_force(measurement, terms);
  std::vector<Eigen::VectorXd> changes_N;
  changes_N.reserve(kEncoderRealisations.size());
  for (const EncoderRealisation& other : kEncoderRealisations) {
    const Measurement realisation = measurement.with_realisation(other);
    changes_N.push_back(measurement.filtered(dry_difference(here, evaluate_dry(realisation, terms))));
  }
  return changes_N;
}

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

/// The noise of each log's force before the filter: as given, or what the differences between samples say,
/// within the bounds that the saturated residual sets.
std::vector<double> force_noise_of_logs_N(const Measurement& measurement, const Terms& plain,
                                          const Eigen::VectorXd& saturated_N,
                                          const std::vector<Eigen::VectorXd>& changes_N) {
  std::vector<double> noise_N(measurement.log_count(), 0.0);
  each_log(measurement, [&](std::size_t log, const LogPart& all) {
    noise_N[log] = all.force_noise_N;
    if (measurement.force_noise_given()) return;
    noise_N[log] =
        residual_noise(measurement, all, saturated_N, changes_N, mass_kg(plain, log)).bounded(noise_N[log]);
  });
  return noise_N;
}

RowVariances variances_at_rows(const Measurement& measurement, const Terms& plain,
                               const std::vector<double>& force_noise_N,
                               const std::vector<Eigen::VectorXd>& changes_N) {
  RowVariances variances{Eigen::VectorXd(measurement.row_count()),
                         Eigen::VectorXd::Zero(measurement.row_count())};
  const double gain = measurement.force_noise_gain({});
  for (const LogPart& part : measurement.parts()) {
    const double inertia_N = mass_kg(plain, part.log) * measurement.acceleration_noise_mps2(part);
    variances.noise
        .segment(static_cast<Eigen::Index>(part.first_row), static_cast<Eigen::Index>(part.row_count))
        .setConstant(squared(gain * force_noise_N[part.log]) + squared(inertia_N));
  }
  for (const Eigen::VectorXd& change_N : changes_N) {
    variances.quantisation += change_N.cwiseAbs2() / static_cast<double>(changes_N.size());
  }
  return variances;
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

/// Variance for the row weights: averaged, since a row whose error happens to be small is no more reliable
/// than its neighbours.
Eigen::VectorXd variance_to_weigh_by(const RowVariances& rows) {
  return smoothed(rows.noise + rows.quantisation);
}

/// Whether the effect is a force of a period, over position or over time: no smooth curve describes it.
bool is_periodic(const EffectDescription& effect) {
  return effect.acts_as(Acts::force) &&
         std::any_of(effect.shapes.begin(), effect.shapes.end(), [](const ShapeSpec& shape) {
           return shape.kind == ShapeKind::pitch || shape.kind == ShapeKind::frequency;
         });
}

/// Whether this log can show the effect's period: it must fit twice into the travel.
bool fits_into(const EffectDescription& effect, double travel_m) {
  return std::none_of(effect.shapes.begin(), effect.shapes.end(), [&](const ShapeSpec& shape) {
    return shape.kind == ShapeKind::pitch && 2.0 * static_cast<double>(shape.lower) > travel_m;
  });
}

/// The model whose residual becomes the saturated one: mass and hysteresis with what bends them most, viscous
/// friction and a mass beside the declared one, and with the forces that no smooth curve describes.
/// `measurement` is a copy with slip distances of its own.
FittedModel reference_model(Measurement& measurement) {
  const auto declared = measurement.parts().front().mass_kg;
  const bool weightless = declared && *declared == 0.0;
  std::vector<std::string> effects = default_baseline();
  effects.push_back(effect_with_role(Role::viscous_friction).id());
  if (declared && !weightless) effects.push_back(effect_with_role(Role::added_mass).id());
  FittedModel model = fit_effects(measurement, effects, {});
  if (const Term* hysteresis = find_role(model.terms, Role::hysteresis)) {
    measurement.set_slip_distances(refined_slip_distances(*hysteresis, measurement.encoder_resolution_m()));
    model = fit_effects(measurement, effects, {});
  }
  const ValueRange travel = value_range(measurement.position_m());
  for (const EffectDescription& effect : catalogue()) {
    const bool of_mass = effect.has_role(Role::resonance);
    if (!is_periodic(effect) || !fits_into(effect, travel.length()) || (of_mass && weightless)) continue;
    const Trial trial = try_effect(measurement, model, effect, {});
    if (of_mass && has_no_true_mode(trial.terms)) continue;
    model = fit_gains(measurement, trial.terms, &model);
  }
  return model;
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

RowWeighing weigh_rows(Measurement& measurement) {
  const FittedModel plain = fit_effects(measurement, default_baseline(), {});
  Measurement copy = measurement;
  const FittedModel reference = reference_model(copy);
  const Eigen::VectorXd saturated_N = saturated_residual_N(copy, *reference.linearisation);
  const std::vector<Eigen::VectorXd> changes_N = changes_by_quantisation_N(copy, reference.terms);
  RowWeighing weighing;
  weighing.plain = plain.terms;
  weighing.force_noise_N = force_noise_of_logs_N(measurement, reference.terms, saturated_N, changes_N);
  const RowVariances rows =
      variances_at_rows(measurement, reference.terms, weighing.force_noise_N, changes_N);
  measurement.set_noise_variance(rows.noise +
                                 supported_variance(rows, saturated_N, measurement.row_usable()));
  if (const Term* hysteresis = find_role(plain.terms, Role::hysteresis)) {
    measurement.set_slip_distances(refined_slip_distances(*hysteresis, measurement.encoder_resolution_m()));
  }
  const Eigen::VectorXd variance = variance_to_weigh_by(variances_at_rows(
      measurement, plain.terms, weighing.force_noise_N, changes_by_quantisation_N(measurement, plain.terms)));
  weighing.least = variance.minCoeff();
  weighing.enough = std::max({weighing.least, squared(kLeastWeighing * plain.train_rmse_N), 1e-300});
  measurement.set_row_weights(weighing.weights(variance));
  return weighing;
}

Eigen::VectorXd RowWeighing::weights(const Eigen::VectorXd& variance) const {
  return (enough / (enough + (variance.array() - least).max(0.0))).matrix();
}

void RowWeighing::apply(Measurement& chunk) const {
  if (chunk.row_count() == 0) return;
  const RowVariances rows =
      variances_at_rows(chunk, plain, force_noise_N, changes_by_quantisation_N(chunk, plain));
  chunk.set_row_weights(weights(variance_to_weigh_by(rows)));
}

}  // namespace slipstack::workbench
