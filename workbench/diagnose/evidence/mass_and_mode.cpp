// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/mass_and_mode.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/model/effects/effect_catalogue.h"

namespace slipstack::workbench {
namespace {

/// Gain of the mode.
constexpr std::size_t kModal = 0;

/// A payload is added only if the error without it is larger by this share: the formula of the mode is never
/// exactly that of the axis. Chosen.
constexpr double kLeastRise = 0.10;

/// A rigid mass within this share of the modal mass counts as zero: the arm is mounted on the declared mass.
/// A rigid mass further below zero means that the arm is a part of the declared mass, because a payload is
/// not negative. Chosen.
constexpr double kStandsOnDeclared = 0.15;

std::size_t rigid_gain(const Term& mode) {
  return static_cast<std::size_t>(mode.effect->traits.axis_mass_gain);
}

/// Puts payload and delay in place of the mode where the error is hardly larger.
bool replace_by_payload_and_delay(const Measurement& measurement, Explanation& explanation) {
  if (has_role(explanation.model.terms, Role::measurement_delay)) return false;
  const EffectDescription& mode = effect_with_role(Role::resonance);
  const EffectDescription& payload = effect_with_role(Role::added_mass);
  const EffectDescription& delay = effect_with_role(Role::measurement_delay);
  Terms terms = without(explanation.model.terms, mode.text.id);
  terms.push_back(make_term(measurement, payload));
  const FittedModel heavier = fit_gains(measurement, std::move(terms), &explanation.model);
  const Trial trial = try_effect(measurement, heavier, delay, {});
  FittedModel both = fit_gains(measurement, trial.terms, &heavier);
  if (!hardly_worse(both, explanation.model)) return false;
  explanation.model = std::move(both);
  std::erase(explanation.added, mode.id());
  explanation.added.push_back(payload.id());
  explanation.added.push_back(delay.id());
  return true;
}

/// The terms with the rigid mass of the mode fixed in every set of gains.
Terms with_rigid_mass(Terms terms, double share_of_modal) {
  for (Term& term : terms) {
    if (!term.effect->has_role(Role::resonance)) continue;
    const std::size_t rigid = rigid_gain(term);
    for (std::size_t set = 0; set < term.gain_sets(); ++set) {
      double* const gains = term.gains.data() + set * term.gains_per_set();
      const std::size_t at = set * term.gains_per_set() + rigid;
      gains[rigid] = share_of_modal * gains[kModal];
      term.lower[at] = term.upper[at] = gains[rigid];
    }
  }
  return terms;
}

/// Adds a payload beside the mode where the rigid mass is neither of the two that an arm can have.
void split_payload_off(const Measurement& measurement, const SelectionContext& context,
                       Explanation& explanation) {
  const Term& mode = *find_role(explanation.model.terms, Role::resonance);
  const double modal_kg = mode.gains[kModal];
  if (!(modal_kg > 0.0)) return;
  const bool within_declared = mode.gains[rigid_gain(mode)] < -kStandsOnDeclared * modal_kg;
  Terms alone = with_rigid_mass(explanation.model.terms, within_declared ? -1.0 : 0.0);
  const FittedModel pinned = fit_gains(measurement, alone, &explanation.model);
  if (!is_significant(context, pinned, explanation.model) ||
      pinned.holdout_rmse_N < (1.0 + kLeastRise) * explanation.model.holdout_rmse_N) {
    return;
  }
  const EffectDescription& payload = effect_with_role(Role::added_mass);
  alone.push_back(make_term(measurement, payload));
  FittedModel split = fit_gains(measurement, std::move(alone), &explanation.model);
  if (!hardly_worse(split, explanation.model)) return;
  explanation.model = std::move(split);
  explanation.added.push_back(payload.id());
}

}  // namespace

void name_mass_beside_mode(const Measurement& measurement, const SelectionContext& context,
                           Explanation& explanation) {
  const Terms& terms = explanation.model.terms;
  const bool mass_is_known = has_role(terms, Role::inertia) && !mass_is_free(terms);
  const std::string mode = effect_with_role(Role::resonance).id();
  const bool mode_is_new =
      std::find(explanation.added.begin(), explanation.added.end(), mode) != explanation.added.end();
  if (!mass_is_known || !mode_is_new || has_role(terms, Role::added_mass)) return;
  if (!replace_by_payload_and_delay(measurement, explanation))
    split_payload_off(measurement, context, explanation);
}

}  // namespace slipstack::workbench
