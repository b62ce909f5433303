// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/search/search.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/diagnose/alternatives/causes.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/diagnose/search/elimination_and_exchange.h"
#include "workbench/diagnose/search/forward_selection.h"
#include "workbench/diagnose/search/mass_and_mode.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// Explanations that are kept from level to level. Chosen on the blind bench.
constexpr std::size_t kBeam = 3;
/// Attempts of a level that are fitted in full: as many again as are kept, because the order to first order
/// is not that of the criterion.
constexpr std::size_t kFitted = 2 * kBeam;
/// Attempts of a later level whose shapes are searched, after a look at all with those of the first level.
/// With half as many EMPS from inertia alone loses the map over the position (1.57 N held out in place of
/// 1.26 N); with all of them the verdicts on 178 training logs are the same, but for the third effect of one.
constexpr std::size_t kSearched = 3 * kFitted;

/// Adds every further effect to every explanation of the beam: all to first order, the best fitted in full,
/// of which the plausible ones are returned, the best first. `known`: trials whose shapes the searches start
/// from; null on the first level, whose trials are stored, since all of them are reported as candidates.
std::vector<Explanation> grow(const DiagnoseOptions& options, const std::vector<Explanation>& beam,
                              const std::vector<Trial>* known, Found& found) {
  const SelectionContext& context = found.context;
  const bool first = known == nullptr;
  std::vector<Attempt> attempts = try_effects(context.measurement, options, beam, known, kSearched);
  if (first) {
    found.alone.reserve(attempts.size());
    for (const Attempt& attempt : attempts) found.alone.push_back(attempt.trial);
  }
  std::vector<Explanation> grown = fit_best(context, std::move(attempts), kFitted);
  if (first) found.first_level = grown;
  std::vector<char> implausible(grown.size());
  parallel_for(grown.size(), [&](std::size_t i) {
    implausible[i] = is_implausible(context.measurement, context.baseline, grown[i].model) ? 1 : 0;
  });
  std::vector<Explanation> plausible;
  for (std::size_t i = 0; i < grown.size(); ++i) {
    if (implausible[i] == 0) plausible.push_back(std::move(grown[i]));
  }
  sort_by_criterion(context, plausible);
  return plausible;
}

/// An explanation with its shapes refined before further effects are tried. A delay also gets its low pass:
/// the error of a low pass that is modelled as a delay resembles a mode.
Explanation refined(const SelectionContext& context, Explanation explanation) {
  FittedModel model = refine_shapes_in_turn(context.measurement, std::move(explanation.model), kRefinement);
  if (has_role(model.terms, Role::measurement_delay))
    model = refine_delay(context.measurement, std::move(model));
  return {std::move(model), std::move(explanation.added)};
}

/// Effects are added one after the other to the best explanation as long as the criterion falls. Where it
/// does not, and the error is still above the floor, once more from new starting points: an effect that a
/// larger one hid on the first level had meaningless shapes there. `path`: receives the best explanation of
/// each level.
void add_effects(Measurement& measurement, const DiagnoseOptions& options, Found& found,
                 std::vector<Explanation>& path) {
  const SelectionContext& context = found.context;
  const auto is_step_on = [&](const std::vector<Explanation>& next) {
    return !next.empty() && is_step(context, found.best, next.front());
  };
  std::vector<Explanation> beam{found.best};
  while (true) {
    const bool first = found.alone.empty();
    std::vector<Explanation> next = grow(options, beam, first ? nullptr : &found.alone, found);
    if (!first && !found.best.added.empty() && !is_step_on(next)) {
      const std::vector<Trial> none;
      next = grow(options, {found.best}, &none, found);
    }
    if (next.empty()) break;
    if (is_step_on(next)) {
      next.front() = refined(context, std::move(next.front()));
      found.best = next.front();
      path.push_back(found.best);
      lower_noise_floor(measurement, *found.best.model.linearisation);
      if (!is_above_floor(context.measurement, found.best.model)) break;
    } else if (!first) {  // a pair may be a step where its first effect is none
      if (is_improvement(context, found.best, next.front())) found.withheld = std::move(next.front());
      break;
    }
    if (next.size() > kBeam) next.resize(kBeam);
    beam = std::move(next);
  }
}

/// Drops what is superfluous, exchanges what another effect explains better, and refines all shapes. The
/// effects that were dropped because they are implausible with refined shapes, or undetermined, are appended
/// to `refused`; those that are in it take the place of no other.
void improve(Found& found, std::vector<std::string>& refused) {
  const auto refuse = [&](const std::vector<std::string>& dropped) {
    refused.insert(refused.end(), dropped.begin(), dropped.end());
  };
  refuse(drop_superfluous(found.context, found.best));
  exchange_effects(found.context, found.alone, refused, found.best);
  exchange_for_delayed_special_cases(found.context, found.alone, refused, found.best);
  name_mass_beside_mode(found.context, found.best);
  FittedModel model = refine_nominal_shapes(found.context.measurement, std::move(found.best.model));
  found.best.model = refine_all_shapes(found.context.measurement, std::move(model));
  // With refined shapes, the first effect may explain what another was added for, or be implausible.
  refuse(drop_superfluous(found.context, found.best));
  refuse(drop_undetermined(found.context, found.best));
}

/// Goes back to the last explanation of the path that has all effects of the best one, none that was refused,
/// fewer than `most`, and is a step on it; and improves it. Of two effects that stand for each other each is
/// no step beside the other, and the elimination may end with neither.
void recover_step(Found& found, const std::vector<Explanation>& path, std::size_t most,
                  std::vector<std::string>& refused) {
  const auto lost = std::find_if(path.rbegin(), path.rend(), [&](const Explanation& one) {
    const auto is_in = [&](const std::string& id) { return contains(one.model.terms, id); };
    return one.added.size() < most && one.added.size() > found.best.added.size() &&
           std::all_of(found.best.added.begin(), found.best.added.end(), is_in) &&
           std::none_of(refused.begin(), refused.end(), is_in) && is_step(found.context, found.best, one);
  });
  if (lost == path.rend()) return;
  found.best = *lost;
  improve(found, refused);
}

/// The last explanation of the path that has none of the effects; without one the baseline.
Explanation last_without(const std::vector<std::string>& effects, const std::vector<Explanation>& path,
                         const FittedModel& baseline) {
  const auto found = std::find_if(path.rbegin(), path.rend(), [&](const Explanation& one) {
    return std::none_of(effects.begin(), effects.end(),
                        [&](const std::string& id) { return contains(one.model.terms, id); });
  });
  return found == path.rend() ? Explanation{baseline, {}} : *found;
}

/// The search from `found.best` on, to its end. An effect that was chosen and then refused kept others out,
/// or led to others: the search goes on without it, from what is left and from where it was chosen.
void choose_effects(Measurement& measurement, const DiagnoseOptions& options, Found& found) {
  std::vector<Explanation> path;
  add_effects(measurement, options, found, path);
  DiagnoseOptions remaining = options;
  if (remaining.candidates.empty()) {
    for (const EffectDescription& effect : catalogue()) remaining.candidates.push_back(effect.id());
  }
  std::vector<std::string> refused;
  while (!found.best.added.empty()) {
    const std::size_t chosen = found.best.added.size();
    improve(found, refused);
    recover_step(found, path, chosen, refused);
    const auto fewer = std::erase_if(remaining.candidates, [&](const std::string& id) {
      return std::find(refused.begin(), refused.end(), id) != refused.end();
    });
    // No candidates at all would mean all of the catalogue.
    if (fewer == 0 || remaining.candidates.empty() || !is_above_floor(measurement, found.best.model)) return;
    const Explanation before = last_without(refused, path, found.context.baseline);
    add_effects(measurement, remaining, found, path);
    Explanation from_rest = std::exchange(found.best, before);
    add_effects(measurement, remaining, found, path);
    if (is_better(found.context, from_rest, found.best)) found.best = std::move(from_rest);
  }
}

/// The trials of effects that are special cases of those of the explanation.
std::vector<Trial> special_cases(const Found& found, const Explanation& explanation) {
  std::vector<Trial> special;
  for (const std::string& id : explanation.added) {
    const SpecialCase& simpler = find_term(explanation.model.terms, id)->effect->traits.special_case;
    if (const Trial* const alone = find_trial(found.alone, simpler.id)) special.push_back(*alone);
  }
  return special;
}

/// Adds those of `terms` to the explanation that are plausible and a step on it, the best first.
void add_steps_of(const SelectionContext& context, Terms terms, Explanation& explanation) {
  while (!terms.empty()) {
    std::vector<Explanation> more;
    for (const Term& term : terms) {
      Terms all = explanation.model.terms;
      all.push_back(term);
      FittedModel model = fit_gains(context.measurement, std::move(all), &explanation.model);
      more.push_back(
          {refine_shapes_in_turn(context.measurement, std::move(model), kRefinement), explanation.added});
      more.back().added.push_back(term.id());
    }
    std::erase_if(more, [&](const Explanation& one) {
      return !is_step(context, explanation, one) ||
             is_implausible(context.measurement, context.baseline, one.model);
    });
    if (more.empty()) return;
    sort_by_criterion(context, more);
    explanation = std::move(more.front());
    std::erase_if(terms, [&](const Term& term) { return term.id() == explanation.added.back(); });
  }
}

/// The effects that were chosen beside causes and are not in the explanation, and the special cases of them;
/// of causes too where that is wanted: a curve over time has an offset in it.
Terms lost_beside_causes(const Found& found, const Terms& joint, bool of_causes,
                         const Explanation& explanation) {
  Terms lost;
  const auto add = [&](const Term& term) {
    if (!contains(explanation.model.terms, term.effect->text.id) && !contains(lost, term.effect->text.id))
      lost.push_back(term);
  };
  for (const std::string& id : found.outside.beside) add(*find_term(joint, id));
  for (const Term& term : joint) {
    if (contains(found.context.baseline.terms, term.effect->text.id)) continue;
    if (!of_causes && is_outside_catalogue(*term.effect)) continue;
    const Trial* const special = find_trial(found.alone, term.effect->traits.special_case.id);
    if (special != nullptr) add(special->term);
  }
  return lost;
}

/// Of the effects that were chosen beside causes those that are steps without them too, or their special case
/// where that suffices.
Explanation without_causes(const Found& found, const FittedModel& joint, bool with_their_special_cases) {
  Terms effects = joint.terms;
  std::erase_if(effects, [](const Term& term) { return is_outside_catalogue(*term.effect); });
  Explanation best{found.outside.beside.empty()
                       ? found.context.baseline
                       : fit_gains(found.context.measurement, std::move(effects), &joint),
                   found.outside.beside};
  drop_superfluous(found.context, best);
  // Of two that imitate each other without the causes, the better may be implausible and both be dropped.
  add_steps_of(found.context, lost_beside_causes(found, joint.terms, with_their_special_cases, best), best);
  drop_coulomb_of_hysteresis(found.context, best);
  drop_undetermined(found.context, best);
  exchange_effects(found.context, special_cases(found, best), {}, best);
  return best;
}

/// Effects that leave less than this share of the baseline's discrepancy (mean square) imitate no cause,
/// whatever more a cause explains. On 330 training logs effects that imitate a cause leave 0.21 and more (a
/// payload beside play, an offset under a random walk), hidden effects 0.15 at most (docs/theory.md).
constexpr double kNoImitation = 0.05;

/// Whether effects leave so little that they imitate no cause (kNoImitation).
bool explains_nearly_all(const SelectionContext& context, double effects_N) {
  const double floor_N = context.measurement.noise_floor_N();
  return explained_N2(effects_N, floor_N) <
         kNoImitation * explained_N2(context.baseline.holdout_rmse_N, floor_N);
}

/// The one effect that explains nearly all without any cause, if there is one. What was chosen beside causes
/// is only what they leave: a curve over the time since a reversal is, in a motion that repeats, any curve.
/// Several effects together imitate a cause (a mode and a payload a loose coupling).
std::optional<Explanation> sufficient_effect(Measurement& measurement, const DiagnoseOptions& options,
                                             const Found& found) {
  const bool may_suffice = std::any_of(found.alone.begin(), found.alone.end(), [&](const Trial& trial) {
    return explains_nearly_all(found.context, trial.holdout_rmse_N);
  });
  if (!may_suffice) return {};
  Found other{{found.context.baseline, {}}, {}, found.context, found.alone, {}, {}};
  DiagnoseOptions effects_only = options;
  effects_only.with_causes = false;
  choose_effects(measurement, effects_only, other);
  const bool suffices =
      other.best.added.size() == 1 && explains_nearly_all(found.context, other.best.model.holdout_rmse_N);
  return suffices ? std::optional(std::move(other.best)) : std::nullopt;
}

/// Whether causes are what the log shows, and the effects only imitate them: alone they leave less than the
/// effects do alone; unless the effects explain nearly all of what there is beyond the floor (kNoImitation),
/// or most of it, and the causes less than half of the rest. A curve over time that has an offset in it
/// always leaves less than an offset, and what comes after load reversals less than a payload, its special
/// case.
bool causes_explain_most(const SelectionContext& context, const FittedModel& causes_alone,
                         const FittedModel& effects_alone, const FittedModel& joint) {
  const double floor_N = context.measurement.noise_floor_N();
  const double effects_N = effects_alone.holdout_rmse_N;
  const bool only_the_rest = explains_most(context.baseline.holdout_rmse_N, effects_N, floor_N) &&
                             !explains_most(effects_N, joint.holdout_rmse_N, floor_N);
  return causes_alone.holdout_rmse_N < effects_N && !only_the_rest &&
         !explains_nearly_all(context, effects_N);
}

/// Where causes explain most, the effects that they supplement keep their names alone.
void keep_supplemented(const FittedModel& joint, const Terms& causes, Found& found) {
  Explanation kept = found.best;
  std::erase_if(kept.added, [&](const std::string& id) {
    const EffectDescription& effect = *find_term(found.best.model.terms, id)->effect;
    return std::none_of(causes.begin(), causes.end(),
                        [&](const Term& cause) { return supplements(*cause.effect, effect); });
  });
  if (kept.added.empty()) return;
  Terms terms = found.context.baseline.terms;
  for (const std::string& id : kept.added) terms.push_back(*find_term(found.best.model.terms, id));
  kept.model = fit_gains(found.context.measurement, std::move(terms), &joint);
  found.best = std::move(kept);
  found.outside.explain_most = false;
}

/// Takes what is outside the catalogue from the results: no controller has it. What was chosen beside it is
/// reported without it.
void set_causes_apart(Measurement& measurement, const DiagnoseOptions& options, Found& found) {
  const auto is_cause = [](const Term& term) { return is_outside_catalogue(*term.effect); };
  std::erase_if(found.alone, [&](const Trial& trial) { return is_cause(trial.term); });
  std::erase_if(found.first_level, [&](const Explanation& one) { return is_cause(one.model.terms.back()); });
  Terms causes = found.best.model.terms;
  std::erase_if(causes, [&](const Term& term) { return !is_cause(term); });
  if (causes.empty()) return;
  const FittedModel joint = std::move(found.best.model);
  std::vector<std::string>& beside = found.outside.beside;
  beside = std::move(found.best.added);
  Terms without_effects = found.context.baseline.terms;
  for (const Term& cause : causes) {
    without_effects.push_back(cause);
    std::erase(beside, cause.id());
  }
  const auto is_friction = [](const Term& cause) { return cause.effect->acts_as(Acts::dry); };
  found.outside.replace_friction = std::any_of(causes.begin(), causes.end(), is_friction);
  const FittedModel causes_alone = fit_gains(measurement, std::move(without_effects), &joint);
  const bool have_special_cases = std::any_of(causes.begin(), causes.end(), [](const Term& cause) {
    return *cause.effect->traits.special_case.id != '\0';
  });
  for (const bool with_their_special_cases : {true, false}) {
    if (with_their_special_cases && !have_special_cases) continue;
    found.best = without_causes(found, joint, with_their_special_cases);
    // Friction of another form is no other explanation of an effect: it takes the place of the hysteresis.
    Terms beside_friction = found.best.model.terms;
    std::copy_if(causes.begin(), causes.end(), std::back_inserter(beside_friction), is_friction);
    const FittedModel effects_alone = fit_gains(measurement, std::move(beside_friction), &joint);
    found.outside.explain_most = causes_explain_most(found.context, causes_alone, effects_alone, joint);
    if (found.outside.explain_most) keep_supplemented(joint, causes, found);
    if (!found.outside.explain_most) break;
  }
  if (found.outside.explain_most) {
    if (auto sufficient = sufficient_effect(measurement, options, found)) {
      found.best = *std::move(sufficient);
      found.outside.explain_most = false;
    }
  }
  std::erase_if(beside, [&](const std::string& id) { return contains(found.best.model.terms, id); });
  for (const Term& cause : causes) {
    const FittedModel others = fit_gains(measurement, without(joint.terms, cause.id()), &joint);
    found.outside.causes.push_back(described_cause(measurement, joint, cause, others.holdout_rmse_N));
  }
  tell_together(found.outside.causes, beside, joint.holdout_rmse_N);
}

/// Whether `more` has the effects of `best`, in any order, and one behind them.
bool is_one_more(const Explanation& best, const Explanation& more) {
  return more.added.size() == best.added.size() + 1 &&
         std::is_permutation(best.added.begin(), best.added.end(), more.added.begin());
}

}  // namespace

Found search(Measurement& measurement, const DiagnoseOptions& options, const FittedModel& baseline) {
  const Criterion criterion(measurement, baseline.terms, choices_of(measurement, options, baseline.terms));
  Found found{{}, {}, {measurement, baseline, criterion}, {}, {}, {}};
  found.best.model = baseline;
  choose_effects(measurement, options, found);
  set_causes_apart(measurement, options, found);
  if (found.withheld && !is_one_more(found.best, *found.withheld)) found.withheld.reset();
  lower_noise_floor(measurement, *found.best.model.linearisation);
  return found;
}

}  // namespace slipstack::workbench
