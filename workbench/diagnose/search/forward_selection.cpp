// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/search/forward_selection.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <tuple>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/diagnose/alternatives/causes.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// Whether the effect has the same column as one in the model; or cannot occur, because the log declares a
/// mass of zero (inertia is not part of its force), so that neither payload nor resonance can be seen.
bool is_redundant(const Measurement& measurement, const Terms& terms, const EffectDescription& effect) {
  const bool weightless = measurement.log().mass_kg && *measurement.log().mass_kg == 0.0;
  if (weightless && (effect.has_role(Role::resonance) || effect.has_role(Role::added_mass))) return true;
  // A line with a bend beside what bends alike.
  if (effect.has_shape(ShapeKind::travel) && effect.acts_as(Acts::force) &&
      bends_like_one_turn(measurement, terms)) {
    return true;
  }
  return (effect.has_role(Role::added_mass) && mass_is_free(terms)) ||
         (effect.has_role(Role::inertia) && has_role(terms, Role::added_mass));
}

/// The effects of the catalogue that the options ask for.
std::vector<const EffectDescription*> wanted_effects(const DiagnoseOptions& options) {
  std::vector<const EffectDescription*> effects;
  effects.reserve(std::max(options.candidates.size(), catalogue().size()));
  for (const std::string& id : options.candidates) effects.push_back(find_effect(id));
  if (options.candidates.empty()) {
    for (const EffectDescription& effect : catalogue()) effects.push_back(&effect);
  }
  return effects;
}

/// The effects to try on top of `terms`. User-defined effects come first: they take longest, and parallel
/// work is balanced best when it begins with the longest tasks.
std::vector<const EffectDescription*> effects_to_try(const Measurement& measurement,
                                                     const DiagnoseOptions& options, const Terms& terms) {
  std::vector<const EffectDescription*> effects;
  for (const EffectDescription* effect : options.user_effects) {
    if (!contains(terms, effect->text.id)) effects.push_back(effect);
  }
  for (const EffectDescription* effect : wanted_effects(options)) {
    if (contains(terms, effect->text.id) || !period_fits(measurement, *effect) ||
        is_redundant(measurement, terms, *effect)) {
      continue;
    }
    effects.push_back(effect);
  }
  if (!options.with_causes) return effects;
  for (const EffectDescription* cause : causes_to_try(measurement, terms)) {
    if (!contains(terms, cause->text.id)) effects.push_back(cause);
  }
  return effects;
}

/// A trial of a cause outside the catalogue; the base alone where the residual has none. `near`: where the
/// search of its shapes begins, or null.
Trial try_cause(const Measurement& measurement, const FittedModel& from, const EffectDescription& cause,
                const std::vector<double>* near, const SearchEffort& effort) {
  if (const auto shapes = shapes_of_cause(measurement, from, cause, near, effort))
    return try_effect(measurement, from, cause, kUnmoved, &*shapes);
  Trial none;
  none.term = make_term(measurement, cause);
  none.terms = from.terms;
  none.terms.push_back(none.term);
  none.holdout_rmse_N = from.holdout_rmse_N;
  none.block_squared_error = from.block_squared_error;
  none.below_visible = true;
  return none;
}

/// A trial of an effect or a cause whose shapes are searched from `near`, or from its starting points.
Trial try_with(const Measurement& measurement, const FittedModel& from, const EffectDescription& effect,
               const SearchEffort& effort, const std::vector<double>* near) {
  return is_outside_catalogue(effect) && !is_searched_as_effect(effect)
             ? try_cause(measurement, from, effect, near, effort)
             : try_effect(measurement, from, effect, effort, near);
}

/// An effect on top of an explanation with the shapes that the first level found. Pitches, frequencies and
/// delays, whose best values may differ with another residual (what a delay alone shifts best may be all but
/// the ripple that it delays most), and shapes of what the first level did not show, are
/// those of their best starting point; what is found from the residual is found anew.
Trial look_again(const Measurement& measurement, const FittedModel& from, const EffectDescription& effect,
                 const std::vector<Trial>& alone) {
  const Trial* const first = find_trial(alone, effect.text.id);
  const bool elsewhere = first == nullptr || first->below_visible || effect.has_shape(ShapeKind::pitch) ||
                         effect.has_shape(ShapeKind::frequency) || effect.has_shape(ShapeKind::delay) ||
                         effect.has_shape(ShapeKind::user_defined);
  return elsewhere ? try_at_best_start(measurement, from, effect)
                   : try_with(measurement, from, effect, kUnmoved, &first->term.shapes);
}

std::vector<std::string> added_by(const Attempt& attempt) {
  std::vector<std::string> added = attempt.from->added;
  added.push_back(attempt.effect->id());
  return added;
}

bool same_set(std::vector<std::string> a, std::vector<std::string> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  return a == b;
}

/// By error, then by id: the order of effects that do nothing must not depend on the catalogue.
void sort_by_error(std::vector<Attempt>& attempts) {
  std::sort(attempts.begin(), attempts.end(), [](const Attempt& a, const Attempt& b) {
    return std::tuple(a.trial.holdout_rmse_N, std::string_view(a.effect->text.id), a.from) <
           std::tuple(b.trial.holdout_rmse_N, std::string_view(b.effect->text.id), b.from);
  });
}

/// The order in which attempts are worked on: those with the most shapes to search first, so that at the end
/// no processor waits long for another.
std::vector<std::size_t> longest_first(const std::vector<Attempt>& attempts) {
  std::vector<std::size_t> order(attempts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return attempts[a].effect->shapes.size() > attempts[b].effect->shapes.size();
  });
  return order;
}

}  // namespace

std::vector<Attempt> try_effects(const Measurement& measurement, const DiagnoseOptions& options,
                                 const std::vector<Explanation>& beam, const std::vector<Trial>* alone,
                                 std::size_t searched) {
  std::vector<Attempt> attempts;
  for (const Explanation& from : beam) {
    for (const EffectDescription* effect : effects_to_try(measurement, options, from.model.terms))
      attempts.push_back({&from, effect, {}});
  }
  const char* const stage = alone == nullptr ? "try every effect" : "try every effect on top";
  options.report(stage, 0.0);  // before the first result, which is shown with the stage it belongs to
  std::atomic<std::size_t> done{0};
  const std::vector<std::size_t> order = longest_first(attempts);
  parallel_for(attempts.size(), [&](std::size_t i) {
    Attempt& one = attempts[order[i]];
    one.trial = alone == nullptr ? try_anew(measurement, one.from->model, *one.effect)
                                 : look_again(measurement, one.from->model, *one.effect, *alone);
    if (alone == nullptr && options.tried && !is_outside_catalogue(*one.effect)) {
      options.tried(one.trial, one.from->model.holdout_rmse_N);
    }
    const std::size_t finished = ++done;
    options.report(stage, static_cast<double>(finished) / static_cast<double>(attempts.size()));
  });
  sort_by_error(attempts);
  if (alone == nullptr) return attempts;
  parallel_for(std::min(attempts.size(), searched), [&](std::size_t i) {
    Attempt& one = attempts[i];
    one.trial = with_shapes_searched(measurement, one.from->model, std::move(one.trial), kRefinement);
  });
  sort_by_error(attempts);
  return attempts;
}

std::vector<Explanation> fit_best(const SelectionContext& context, std::vector<Attempt> attempts,
                                  std::size_t most) {
  std::vector<Attempt> distinct;
  for (Attempt& attempt : attempts) {
    if (!is_shown(attempt.from->model.holdout_rmse_N, attempt.trial.holdout_rmse_N)) continue;
    const bool seen = std::any_of(distinct.begin(), distinct.end(), [&](const Attempt& other) {
      return same_set(added_by(other), added_by(attempt));
    });
    if (!seen) distinct.push_back(std::move(attempt));
    if (distinct.size() == most) break;
  }
  std::vector<Explanation> grown(distinct.size());
  parallel_for(distinct.size(), [&](std::size_t i) {
    const Attempt& attempt = distinct[i];
    grown[i] = {fit_gains(context.measurement, attempt.trial.terms, &attempt.from->model), added_by(attempt)};
  });
  return grown;
}

Trial try_anew(const Measurement& measurement, const FittedModel& from, const EffectDescription& effect) {
  return try_with(measurement, from, effect, kFirstLook, nullptr);
}

Trial try_at_best_start(const Measurement& measurement, const FittedModel& from,
                        const EffectDescription& effect) {
  return try_with(measurement, from, effect, kUnmoved, nullptr);
}

Trial with_shapes_searched(const Measurement& measurement, const FittedModel& from, Trial trial,
                           const SearchEffort& effort) {
  const EffectDescription& effect = *trial.term.effect;
  if (trial.below_visible || (is_outside_catalogue(effect) && !is_fitted_jointly(effect))) return trial;
  return try_with(measurement, from, effect, effort, &trial.term.shapes);
}

std::size_t choices_of(const Measurement& measurement, const DiagnoseOptions& options,
                       const Terms& baseline) {
  return effects_to_try(measurement, options, baseline).size();
}

const Trial* find_trial(const std::vector<Trial>& trials, std::string_view id) {
  const auto found = std::find_if(trials.begin(), trials.end(),
                                  [&](const Trial& one) { return id == one.term.effect->text.id; });
  return found == trials.end() ? nullptr : &*found;
}

}  // namespace slipstack::workbench
