// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/search/elimination_and_exchange.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/alternatives/cause_forms.h"
#include "workbench/diagnose/alternatives/causes.h"
#include "workbench/diagnose/evidence/bounds.h"
#include "workbench/diagnose/evidence/contains_zero.h"
#include "workbench/diagnose/evidence/implausible_causes.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/diagnose/search/forward_selection.h"
#include "workbench/estimate/nonlinear/fit.h"
#include "workbench/estimate/uncertainty/friction_each_way.h"
#include "workbench/estimate/uncertainty/standard_errors.h"

namespace slipstack::workbench {
namespace {

std::vector<std::string> with_other(std::vector<std::string> added, const std::string& old,
                                    const std::string& other) {
  for (std::string& id : added) {
    if (id == old) id = other;
  }
  return added;
}

/// The trials of effects on top of the explanation without one of its effects, those that may take its place:
/// to first order they leave no error whose difference is worth a name. Of an explanation that reaches the
/// floor only effects that do something alone are tried; otherwise another one may have hidden them.
std::vector<Trial> replacements(const SelectionContext& context, const std::vector<Trial>& alone,
                                const std::vector<std::string>& refused, const Explanation& explanation,
                                const FittedModel& without_old) {
  std::vector<const EffectDescription*> others;
  for (const Trial& other : alone) {
    if (std::find(refused.begin(), refused.end(), other.term.id()) != refused.end()) continue;
    if (!contains(explanation.model.terms, other.term.effect->text.id) &&
        (is_above_floor(context.measurement, explanation.model) ||
         is_worth_a_name(context.baseline.holdout_rmse_N, other.holdout_rmse_N))) {
      others.push_back(other.term.effect);
    }
  }
  std::vector<Trial> trials(others.size());
  parallel_for(trials.size(), [&](std::size_t i) {
    trials[i] = try_at_best_start(context.measurement, without_old, *others[i]);
  });
  // A search of the shapes would have to explain most of what is left.
  std::erase_if(trials, [&](const Trial& trial) {
    return kMajority * squared(trial.holdout_rmse_N) > squared(explanation.model.holdout_rmse_N);
  });
  parallel_for(trials.size(), [&](std::size_t i) {
    trials[i] = with_shapes_searched(context.measurement, without_old, std::move(trials[i]), kFirstLook);
  });
  std::erase_if(trials, [&](const Trial& trial) {
    return is_worth_a_name(trial.holdout_rmse_N, explanation.model.holdout_rmse_N);
  });
  return trials;
}

}  // namespace

namespace {

/// The explanation without its effect `i`, fitted anew.
Explanation without_effect(const SelectionContext& context, const Explanation& explanation, std::size_t i) {
  std::vector<std::string> added = explanation.added;
  added.erase(added.begin() + static_cast<std::ptrdiff_t>(i));
  if (added.empty()) return {context.baseline, {}};
  FittedModel model = fit_gains(context.measurement, without(explanation.model.terms, explanation.added[i]),
                                &explanation.model);
  model = refine_shapes_in_turn(context.measurement, std::move(model), kRefinement);
  return {with_causes_found_again(context.measurement, std::move(model)), std::move(added)};
}

/// Whether a mode, a lag, a second ripple or an effect with a shape at a bound was dropped that refined
/// shapes have made implausible; its id is appended to `implausible`.
bool drop_implausible(const SelectionContext& context, Explanation& explanation,
                      std::vector<std::string>& implausible) {
  const bool no_mode = has_implausible_mode(context.measurement, context.baseline, explanation.model);
  const bool no_lag = has_implausible_lag(context.measurement, context.baseline, explanation.model);
  const bool at_bound = has_shape_at_bound(context.measurement, context.baseline, explanation.model);
  const bool twice = has_one_ripple_twice(context.measurement, explanation.model.terms);
  for (std::size_t i = 0; i < explanation.added.size(); ++i) {
    const Terms rest = without(explanation.model.terms, explanation.added[i]);
    const auto is_at_bound = [&] {
      FittedModel alone = context.baseline;
      alone.terms.push_back(*find_term(explanation.model.terms, explanation.added[i]));
      return has_shape_at_bound(context.measurement, context.baseline, alone);
    };
    if ((at_bound && is_at_bound()) || (twice && find_cause(rest, CauseForm::second_ripple) == nullptr) ||
        (no_mode && !has_role(rest, Role::resonance)) || (no_lag && !has_role(rest, Role::friction_memory))) {
      implausible.push_back(explanation.added[i]);
      explanation = without_effect(context, explanation, i);
      return true;
    }
  }
  return false;
}

/// Whether an effect was dropped that is no step: of several the one whose lack the criterion prefers most.
/// Beside one that is superfluous another seems to be (an offset beside an asymmetry).
bool drop_no_step(const SelectionContext& context, Explanation& explanation) {
  std::vector<Explanation> fewer(explanation.added.size());
  parallel_for(fewer.size(), [&](std::size_t i) { fewer[i] = without_effect(context, explanation, i); });
  std::erase_if(fewer, [&](const Explanation& one) {
    return lacks_supplemented(one.model.terms) || is_step(context, one, explanation);
  });
  if (fewer.empty()) return false;
  sort_by_criterion(context, fewer);
  explanation = std::move(fewer.front());
  return true;
}

/// Whether the friction forward and backward, which is what the term is named for, is the same: its halves
/// differ by less than two standard errors, or than what a hysteresis of another form leaves. Gains that
/// cancel in steady motion are a form of the friction near reversals.
bool is_equal_each_way(const Measurement& measurement, const FittedModel& model, const Term& term) {
  const auto dry_N = [](const FrictionEachWay& one) { return one.dry_forward_N - one.dry_backward_N; };
  const auto slope = [](const FrictionEachWay& one) { return one.slope_forward - one.slope_backward; };
  const FrictionEachWay all = friction_each_way(model.terms, term);
  std::vector<double> dry_without_N;
  std::vector<double> slope_without;
  for (const Terms& terms : terms_without_blocks(model)) {
    const FrictionEachWay one = friction_each_way(terms, *find_term(terms, term.effect->text.id));
    dry_without_N.push_back(dry_N(one));
    slope_without.push_back(slope(one));
  }
  const double least_N = kFormLeaves * (all.dry_forward_N + all.dry_backward_N);  // between the halves
  const double speed_mps = rms(measurement.velocity_mps());
  return std::abs(dry_N(all)) <= std::max(2.0 * jackknife_error(dry_without_N), least_N) &&
         std::abs(slope(all)) * speed_mps <=
             std::max(2.0 * jackknife_error(slope_without) * speed_mps, least_N);
}

/// Whether the log says nothing of a shape.
bool may_be_anything(const Term& term, std::size_t shape) {
  const bool ended =
      shape_ended_at_bound(term, shape) && term.effect->shapes[shape].kind != ShapeKind::frequency;
  return ended || term.shape_standard_error(shape) > std::abs(term.shapes[shape]);
}

/// Of a memory that decays with time or with distance: the other of the two. A log in which it decays with
/// time says nothing of a distance, and the other way round.
std::optional<std::size_t> other_shape_of_memory(const EffectDescription& effect, std::size_t shape) {
  if (!effect.has_shape(ShapeKind::lag_distance)) return {};
  switch (effect.shapes[shape].kind) {
    case ShapeKind::lag_distance:
      return effect.find_shape(ShapeKind::time_constant);
    case ShapeKind::time_constant:
      return effect.find_shape(ShapeKind::lag_distance);
    default:
      return {};
  }
}

}  // namespace

bool is_undetermined(const Measurement& measurement, const FittedModel& model, const Term& term) {
  if (term.effect->has_role(Role::directional_friction)) return is_equal_each_way(measurement, model, term);
  if (term.effect->has_shape(ShapeKind::travel)) return false;
  if (term.gains.empty()) return each_shape_contains_zero(term) && lag_contains_zero(term);
  for (std::size_t i = 0; i < term.gains.size(); ++i) {
    if (!contains_zero(term.gains[i], term.gain_standard_error(i))) return false;
  }
  if (term.gains_per_set() == 1) return true;
  for (std::size_t i = 0; i < term.shapes.size(); ++i) {
    const auto other = other_shape_of_memory(*term.effect, i);
    if (may_be_anything(term, i) && (!other || may_be_anything(term, *other))) return true;
  }
  return false;
}

std::vector<std::string> drop_superfluous(const SelectionContext& context, Explanation& explanation) {
  std::vector<std::string> implausible;
  // What was needed beside the dropped one may no longer be. The implausible one first: beside it another may
  // seem to be no step.
  while (!explanation.added.empty() &&
         (drop_implausible(context, explanation, implausible) || drop_no_step(context, explanation))) {
  }
  return implausible;
}

void drop_coulomb_of_hysteresis(const SelectionContext& context, Explanation& explanation) {
  if (!coulomb_is_of_hysteresis(explanation.model, context.measurement.noise_floor_N())) return;
  for (std::size_t i = 0; i < explanation.added.size(); ++i) {
    if (!find_term(explanation.model.terms, explanation.added[i])
             ->effect->has_role(Role::saturating_friction))
      continue;
    explanation = without_effect(context, explanation, i);
    return;
  }
}

std::vector<std::string> drop_undetermined(const SelectionContext& context, Explanation& explanation) {
  std::vector<std::string> dropped;
  while (!explanation.added.empty()) {
    const FittedModel known = with_standard_errors(context.measurement, explanation.model);
    const auto effect =
        std::find_if(explanation.added.begin(), explanation.added.end(), [&](const std::string& id) {
          return is_undetermined(context.measurement, known, *find_term(known.terms, id));
        });
    if (effect == explanation.added.end()) break;
    dropped.push_back(*effect);
    explanation =
        without_effect(context, explanation, static_cast<std::size_t>(effect - explanation.added.begin()));
    drop_superfluous(context, explanation);
  }
  return dropped;
}

void exchange_effects(const SelectionContext& context, const std::vector<Trial>& alone,
                      const std::vector<std::string>& refused, Explanation& explanation) {
  for (std::size_t i = 0; i < explanation.added.size(); ++i) {
    const std::string old = explanation.added[i];
    if (lacks_supplemented(without(explanation.model.terms, old))) continue;
    const bool is_effect = !is_outside_catalogue(*find_term(explanation.model.terms, old)->effect);
    const FittedModel without_old =
        fit_gains(context.measurement, without(explanation.model.terms, old), &explanation.model);
    const std::vector<Trial> trials = replacements(context, alone, refused, explanation, without_old);
    std::vector<FittedModel> models(trials.size());
    parallel_for(trials.size(), [&](std::size_t t) {
      FittedModel model = fit_gains(context.measurement, trials[t].terms, &without_old);
      model = refine_shapes_in_turn(context.measurement, std::move(model), kRefinement);
      models[t] = with_causes_found_again(context.measurement, std::move(model));
    });
    for (std::size_t t = 0; t < trials.size(); ++t) {
      Explanation replaced{std::move(models[t]),
                           with_other(explanation.added, explanation.added[i], trials[t].term.id())};
      // What is not of some moments may be told, but takes the place of no effect.
      const bool of_any_time = is_effect && is_outside_catalogue(*trials[t].term.effect) &&
                               lasts_most_of_the_time(context.measurement, replaced.model);
      if (!of_any_time && is_better(context, replaced, explanation) &&
          !is_implausible(context.measurement, context.baseline, replaced.model)) {
        explanation = std::move(replaced);
      }
    }
  }
}

void exchange_for_delayed_special_cases(const SelectionContext& context, const std::vector<Trial>& alone,
                                        const std::vector<std::string>& refused, Explanation& explanation) {
  const std::string delay = effect_with_role(Role::measurement_delay).id();
  const auto is_open = [&](const std::string& id) {
    return find_trial(alone, id) != nullptr && find_term(explanation.model.terms, id) == nullptr &&
           std::find(refused.begin(), refused.end(), id) == refused.end();
  };
  for (std::size_t i = 0; i < explanation.added.size(); ++i) {
    const std::string general = explanation.added[i];
    const std::string special = find_term(explanation.model.terms, general)->effect->traits.special_case.id;
    if (!is_open(special) || !is_open(delay)) continue;
    FittedModel model =
        fit_gains(context.measurement, without(explanation.model.terms, general), &explanation.model);
    for (const std::string& id : {special, delay}) {
      const EffectDescription& effect = *find_trial(alone, id)->term.effect;
      Trial trial = with_shapes_searched(context.measurement, model,
                                         try_at_best_start(context.measurement, model, effect), kFirstLook);
      model = fit_gains(context.measurement, std::move(trial.terms), &model);
    }
    model = refine_shapes_in_turn(context.measurement, std::move(model), kRefinement);
    Explanation delayed{refine_delay(context.measurement, std::move(model)),
                        with_other(explanation.added, general, special)};
    delayed.added.push_back(delay);
    if (is_better(context, delayed, explanation) &&
        !is_implausible(context.measurement, context.baseline, delayed.model)) {
      explanation = std::move(delayed);
    }
  }
}

}  // namespace slipstack::workbench
