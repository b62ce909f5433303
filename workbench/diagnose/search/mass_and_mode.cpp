// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/search/mass_and_mode.h"

#include <algorithm>
#include <utility>

#include "workbench/diagnose/search/elimination_and_exchange.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {
namespace {

/// Gain of the mode.
constexpr std::size_t kModal = 0;

/// The explanation with payload and delay in place of the mode.
Explanation with_payload_and_delay(const SelectionContext& context, const Explanation& explanation) {
  const EffectDescription& mode = effect_with_role(Role::resonance);
  const EffectDescription& payload = effect_with_role(Role::added_mass);
  const EffectDescription& delay = effect_with_role(Role::measurement_delay);
  Terms terms = without(explanation.model.terms, mode.text.id);
  terms.push_back(make_term(context.measurement, payload));
  const FittedModel heavier = fit_gains(context.measurement, std::move(terms), &explanation.model);
  const Trial trial = try_effect(context.measurement, heavier, delay, {});
  std::vector<std::string> added = explanation.added;
  std::erase(added, mode.id());
  added.push_back(payload.id());
  added.push_back(delay.id());
  return {fit_gains(context.measurement, trial.terms, &heavier), std::move(added)};
}

/// The terms with the rigid mass of the mode fixed in every set of gains.
Terms with_rigid_mass(Terms terms, double share_of_modal) {
  for (Term& term : terms) {
    if (!term.effect->has_role(Role::resonance)) continue;
    const auto rigid = static_cast<std::size_t>(term.effect->traits.axis_mass_gain);
    for (std::size_t set = 0; set < term.gain_sets(); ++set) {
      double* const gains = term.gains.data() + set * term.gains_per_set();
      const std::size_t at = set * term.gains_per_set() + rigid;
      gains[rigid] = share_of_modal * gains[kModal];
      term.lower[at] = term.upper[at] = gains[rigid];
    }
  }
  return terms;
}

/// The explanation with the rigid mass of the mode fixed, and with a payload besides; in this order.
std::pair<Explanation, Explanation> with_fixed_arm(const SelectionContext& context,
                                                   const Explanation& explanation, double share_of_modal) {
  Terms terms = with_rigid_mass(explanation.model.terms, share_of_modal);
  Explanation fixed{fit_gains(context.measurement, terms, &explanation.model), explanation.added};
  const EffectDescription& payload = effect_with_role(Role::added_mass);
  terms.push_back(make_term(context.measurement, payload));
  Explanation split{fit_gains(context.measurement, std::move(terms), &explanation.model), explanation.added};
  split.added.push_back(payload.id());
  return {std::move(fixed), std::move(split)};
}

/// Whether the log determines the payload beside the mode.
bool payload_is_determined(const SelectionContext& context, const FittedModel& model) {
  const FittedModel known = with_standard_errors(context.measurement, model);
  return !is_undetermined(context.measurement, known, *find_role(known.terms, Role::added_mass));
}

/// Adds a payload beside the mode where the rigid mass is neither of the two that an arm can have, and the
/// log determines the payload. Else it remains the mode's: without it the mode would be another.
void split_payload_off(const SelectionContext& context, Explanation& explanation) {
  if (!(find_role(explanation.model.terms, Role::resonance)->gains[kModal] > 0.0)) return;
  auto [mounted, mounted_split] = with_fixed_arm(context, explanation, 0.0);
  auto [contained, contained_split] = with_fixed_arm(context, explanation, -1.0);
  // The payload makes up for the difference of the two, so the log cannot tell them apart; but a payload
  // takes no mass away.
  const Term& payload = *find_role(mounted_split.model.terms, Role::added_mass);
  const bool is_contained =
      std::any_of(payload.gains.begin(), payload.gains.end(), [](double mass_kg) { return mass_kg < 0.0; });
  Explanation& split = is_contained ? contained_split : mounted_split;
  const Explanation& arm = is_better(context, mounted, contained) ? mounted : contained;
  if (is_step(context, arm, explanation) && is_step(context, arm, split) &&
      payload_is_determined(context, split.model)) {
    explanation = std::move(split);
  }
}

}  // namespace

void name_mass_beside_mode(const SelectionContext& context, Explanation& explanation) {
  const Terms& terms = explanation.model.terms;
  const bool mass_is_known = has_role(terms, Role::inertia) && !mass_is_free(terms);
  const std::string mode = effect_with_role(Role::resonance).id();
  const bool mode_is_new =
      std::find(explanation.added.begin(), explanation.added.end(), mode) != explanation.added.end();
  if (!mass_is_known || !mode_is_new || has_role(terms, Role::added_mass)) return;
  if (!has_role(terms, Role::measurement_delay)) {
    Explanation other = with_payload_and_delay(context, explanation);
    if (is_better(context, other, explanation)) {
      explanation = std::move(other);
      return;
    }
  }
  split_payload_off(context, explanation);
}

}  // namespace slipstack::workbench
