// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/confounders.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// The share of the baseline's error that the explanation removes.
double reduction_of_all(const Diagnosis& diagnosis) {
  return 1.0 - diagnosis.explained.holdout_rmse_N / diagnosis.baseline.holdout_rmse_N;
}

}  // namespace

std::optional<Structure> curve_behind_all(const Measurement& measurement, const Diagnosis& diagnosis) {
  const Eigen::VectorXd residual_N = weighted_residual(measurement, diagnosis.baseline);
  const auto free = find_structure(measurement, residual_N);
  // That the residual is large at times is no other explanation of it: a mode rings after reversals too.
  const auto best =
      std::find_if(free.begin(), free.end(), [](const Structure& one) { return !one.only_where; });
  if (best == free.end()) return {};
  const double kept = 1.0 - best->error_reduction;
  const double kept_by_effects = 1.0 - reduction_of_all(diagnosis);
  if (kept * kept >= kMajority * kept_by_effects * kept_by_effects) return {};
  return *best;
}

std::optional<Structure> mass_of_another_axis(const Measurement& measurement, const Diagnosis& diagnosis) {
  const auto described = [&](const std::string& description) {
    return Structure{Coordinate::acceleration, reduction_of_all(diagnosis), 0.0,
                     fmt::format("{}: check {}, and the sign and the units of time, position and {}",
                                 description, axis_key("mass_kg"), force_word()),
                     weighted_residual(measurement, diagnosis.baseline)};
  };
  // Some effect then compensates the inertia: a negative payload, a mode of all the mass.
  if (measurement.log().mass_kg && diagnosis.baseline.relative_error > kMostChange) {
    return described(fmt::format("the declared {} would need {:.3g} times the measured {}", mass_word(),
                                 diagnosis.baseline.relative_error, force_word()));
  }
  if (!has_role(diagnosis.explained.terms, Role::added_mass)) return {};
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const double declared_kg = mass_kg(diagnosis.baseline.terms, log);
    const double found_kg = mass_kg(diagnosis.explained.terms, log);
    if (found_kg * kMostChange > declared_kg && found_kg < kMostChange * declared_kg) continue;
    return described(fmt::format("{} and acceleration make a {} of {} where the log declares {}",
                                 force_word(), mass_word(), quantity(found_kg, "kg"),
                                 quantity(declared_kg, "kg")));
  }
  return {};
}

}  // namespace slipstack::workbench
