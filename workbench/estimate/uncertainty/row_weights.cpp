// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/row_weights.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/terms/slip_grid.h"
#include "workbench/estimate/uncertainty/encoder_realisations.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/estimate/uncertainty/reference_model.h"
#include "workbench/estimate/uncertainty/saturated_residual.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// Quantisation below this fraction of the plain model's residual does not lower a row's weight by half.
/// Chosen.
constexpr double kLeastWeighing = 0.1;

std::vector<double> masses_kg(const Measurement& measurement, const Terms& terms) {
  std::vector<double> masses;
  masses.reserve(measurement.log_count());
  for (std::size_t log = 0; log < measurement.log_count(); ++log) masses.push_back(mass_kg(terms, log));
  return masses;
}

/// Variance for the row weights: averaged, since a row whose error happens to be small is no more reliable
/// than its neighbours.
Eigen::VectorXd variance_to_weigh_by(const RowVariances& rows) {
  return smoothed(rows.noise + rows.quantisation);
}

}  // namespace

RowWeighing weigh_rows(Measurement& measurement) {
  FittedModel plain, reference;
  Measurement copy = measurement;
  run_together([&] { plain = fit_effects(measurement, default_baseline(), {}); },
               [&] { reference = reference_model(copy); });
  const Eigen::VectorXd saturated_N = saturated_residual_N(copy, *reference.linearisation);
  std::vector<ForceChanges> changes_N =
      changes_by_quantisation_N(measurement, {&reference.terms, &plain.terms}, 0);
  RowWeighing weighing;
  weighing.plain = plain.terms;
  const std::vector<double> mass_kg = masses_kg(measurement, reference.terms);
  weighing.force_noise_N = force_noise_of_logs_N(measurement, mass_kg, saturated_N, changes_N.front());
  measurement.set_noise_variance(unexplainable_variance(
      variances_at_rows(measurement, mass_kg, weighing.force_noise_N, changes_N.front()), saturated_N,
      measurement.row_usable()));
  if (const Term* hysteresis = find_role(plain.terms, Role::hysteresis)) {
    measurement.set_slip_distances(refined_slip_distances(*hysteresis, measurement.encoder_resolution_m()));
  }
  const Eigen::VectorXd variance = variance_to_weigh_by(variances_at_rows(
      measurement, masses_kg(measurement, plain.terms), weighing.force_noise_N, changes_N.back()));
  measurement.set_noise_readings({mass_kg, std::move(changes_N.front())});
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
  // One realisation in memory at a time, since many threads weigh chunks at once.
  const std::vector<ForceChanges> changes_N = changes_by_quantisation_N(chunk, {&plain}, 1);
  chunk.set_row_weights(weights(variance_to_weigh_by(
      variances_at_rows(chunk, masses_kg(chunk, plain), force_noise_N, changes_N.front()))));
}

}  // namespace slipstack::workbench
