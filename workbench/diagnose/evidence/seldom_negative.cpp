// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/seldom_negative.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "workbench/base/axis_units.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

bool has_seldom_negative_gain(const Term& term) {
  return term.effect->traits.plausible.seldom_negative >= 0;
}

/// Whether the stiffness of a term is below zero: its gain that is so seldom; or, of a force that repeats
/// after a turn, its slope in the middle of the travel.
bool has_negative_stiffness(const Measurement& measurement, const Term& term) {
  if (has_seldom_negative_gain(term))
    return term.gains[static_cast<std::size_t>(term.effect->traits.plausible.seldom_negative)] < 0.0;
  const auto pitch_m = term.shape(ShapeKind::pitch);
  if (!pitch_m || !is_one_turn(*pitch_m) || !term.effect->acts_as(Acts::force)) return false;
  const ValueRange travel = measurement.position_range_m();
  const double middle_rad = 0.5 * (travel.low + travel.high);
  return travel.length() < 0.5 * kTurn_rad &&
         term.gains[1] * std::cos(middle_rad) < term.gains[0] * std::sin(middle_rad);
}

void forbid_negative(Term& term) {
  const auto gain = static_cast<std::size_t>(term.effect->traits.plausible.seldom_negative);
  for (std::size_t i = gain; i < term.gains.size(); i += term.gains_per_set())
    term.gains[i] = term.lower[i] = 0.0;
}

/// The terms without the stiffness of this effect.
Terms without_stiffness(Terms terms, const Term& term) {
  if (!has_seldom_negative_gain(term)) return without(std::move(terms), term.id());
  for (Term& one : terms) {
    if (one.effect == term.effect) forbid_negative(one);
  }
  return terms;
}

}  // namespace

bool is_doubtfully_negative(const Measurement& measurement, const FittedModel& baseline,
                            const FittedModel& model, const Term& term) {
  if (!has_negative_stiffness(measurement, term)) return false;
  Terms alone = baseline.terms;
  alone.push_back(term);
  const FittedModel fitted_alone = fit_gains(measurement, std::move(alone), &baseline);
  if (!has_negative_stiffness(measurement, fitted_alone.terms.back())) return true;
  Terms other = without_stiffness(model.terms, term);
  const EffectDescription& payload = effect_with_role(Role::added_mass);
  if (!mass_is_free(other) && !contains(other, payload.text.id))
    other.push_back(make_term(measurement, payload));
  const double others_N = fit_gains(measurement, std::move(other), &model).holdout_rmse_N;
  return squared(model.holdout_rmse_N) > kMajority * squared(others_N);
}

}  // namespace slipstack::workbench
