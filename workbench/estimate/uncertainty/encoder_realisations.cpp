// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/encoder_realisations.h"

#include <array>
#include <cstddef>

#include "workbench/base/parallel.h"
#include "workbench/estimate/linear/force_trace.h"

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

}  // namespace

std::vector<ForceChanges> changes_by_quantisation_N(const Measurement& measurement,
                                                    const std::vector<const Terms*>& models,
                                                    std::size_t at_once) {
  std::vector<ForceTrace> here;
  here.reserve(models.size());
  for (const Terms* terms : models) here.push_back(evaluate_force(measurement, *terms));
  std::vector<ForceChanges> changes_N(models.size(), ForceChanges(kEncoderRealisations.size()));
  parallel_for(kEncoderRealisations.size(), at_once, [&](std::size_t i) {
    const Measurement realisation = measurement.with_realisation(kEncoderRealisations[i]);
    for (std::size_t m = 0; m < models.size(); ++m) {
      changes_N[m][i] = measurement.filtered(dry_difference(here[m], evaluate_dry(realisation, *models[m])));
    }
  });
  return changes_N;
}

std::vector<double> rounding_through_masses_N2(const Measurement& measurement,
                                               const std::vector<const Terms*>& models) {
  std::vector<Terms> masses;
  masses.reserve(models.size());
  for (const Terms* terms : models) {
    masses.push_back(*terms);
    std::erase_if(masses.back(),
                  [](const Term& term) { return !is_mass(term) && !term.effect->has_role(Role::resonance); });
  }
  std::vector<double> mean_N2(models.size(), 0.0);
  if (!(measurement.encoder_resolution_m() > 0.0)) return mean_N2;
  constexpr std::array kShifts{kGoldenPart, 1.0 - kGoldenPart};
  const double rows = static_cast<double>(measurement.row_count());
  for (const double shift_steps : kShifts) {
    const Measurement rounding = measurement.with_motion(
        measurement.rounding_m(shift_steps), std::vector<double>(measurement.sample_count(), 0.0));
    for (std::size_t m = 0; m < masses.size(); ++m) {
      const std::vector<double> force_N = evaluate_force(rounding, masses[m]).force_N;
      mean_N2[m] += measurement.filtered(force_N).squaredNorm() / (rows * kShifts.size());
    }
  }
  return mean_N2;
}

}  // namespace slipstack::workbench
