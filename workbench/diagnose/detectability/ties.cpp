// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/detectability/ties.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>

#include "workbench/base/axis_words.h"
#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/diagnose/search/forward_selection.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/uncertainty/held_out_error.h"

namespace slipstack::workbench {
namespace {

/// The baseline with one candidate, with the errors that are told of it.
Explanation alone(const SelectionContext& context, const Diagnosis& diagnosis, const Candidate& candidate) {
  FittedModel model = fit_gains(context.measurement, candidate.terms, &diagnosis.baseline);
  model.holdout_rmse_N = candidate.holdout_rmse_N;
  model.block_squared_error = candidate.block_squared_error;
  return {std::move(model), {candidate.term.id()}};
}

/// The explanation with the steps of the diagnosis. Of several steps it is judged on the measurement, as what
/// is tried in their place: of long logs the errors of the diagnosis are those of the whole logs.
Explanation named_explanation(const SelectionContext& context, const Diagnosis& diagnosis) {
  const std::vector<Step>& steps = diagnosis.steps;
  Explanation named{fit_gains(context.measurement, diagnosis.explained.terms, &diagnosis.explained), {}};
  named.model.holdout_rmse_N = steps.back().holdout_rmse_N;
  named.model.block_squared_error = steps.back().block_squared_error;
  if (steps.size() > 2) judge_on_unseen_data(context.measurement, named.model);
  for (std::size_t i = 1; i < steps.size(); ++i) named.added.push_back(steps[i].effect);
  return named;
}

/// The explanation with another effect in place of its effect `i`, fitted as exchange_effects() does; none
/// where it explains far less. `without_old`: the explanation without that effect.
std::optional<Explanation> with_in_place(const SelectionContext& context, const Explanation& named,
                                         std::size_t i, const FittedModel& without_old,
                                         const Candidate& other) {
  const Measurement& measurement = context.measurement;
  const double named_N = named.model.holdout_rmse_N;
  Trial trial = with_shapes_searched(measurement, without_old, {other.term, other.terms, 0.0, {}}, kUnmoved);
  // What explains less than most of what the named one does, no search of its shapes makes a tie.
  if (!explains_most(without_old.holdout_rmse_N, trial.holdout_rmse_N, named_N)) return {};
  trial = with_shapes_searched(measurement, without_old, std::move(trial), kFirstLook);
  if (is_worth_a_name(trial.holdout_rmse_N, named_N)) return {};
  FittedModel model = fit_gains(measurement, std::move(trial.terms), &without_old);
  model = refine_shapes_in_turn(measurement, std::move(model), kRefinement);
  judge_on_unseen_data(measurement, model);
  Explanation replaced{std::move(model), named.added};
  replaced.added[i] = other.term.id();
  return replaced;
}

/// Whether the other effect lowers the error without effect `i` by more than has no name: what is too small
/// for a name takes none from another.
bool is_large_enough(const SelectionContext& context, const FittedModel& without_old,
                     const FittedModel& replaced) {
  return !is_too_small(context.measurement, context.baseline, without_old.terms, replaced.terms,
                       explained_N2(without_old.holdout_rmse_N, replaced.holdout_rmse_N));
}

/// Those of `others` that the log cannot tell from effect `i` of the explanation, with the angles between the
/// forces beside all else that the model has.
std::vector<Separation> ties_with(const SelectionContext& context, const Diagnosis& diagnosis,
                                  const Explanation& named, std::size_t i,
                                  const std::vector<const Candidate*>& others) {
  const bool single = named.added.size() == 1;
  const FittedModel without_old =
      single ? diagnosis.baseline
             : fit_gains(context.measurement, without(named.model.terms, named.added[i]), &named.model);
  std::vector<std::optional<Term>> tied(others.size());
  parallel_for(others.size(), [&](std::size_t c) {
    const Candidate& other = *others[c];
    std::optional<Explanation> replaced;
    if (!single) {
      replaced = with_in_place(context, named, i, without_old, other);
    } else if (explains_most(without_old.holdout_rmse_N, other.holdout_rmse_N, named.model.holdout_rmse_N)) {
      replaced = alone(context, diagnosis, other);
    }
    if (replaced && is_tie(context, named, *replaced) &&
        is_large_enough(context, without_old, replaced->model) &&
        !is_implausible(context.measurement, context.baseline, replaced->model)) {
      tied[c] = *find_term(replaced->model.terms, other.term.id());
    }
  });
  std::vector<Separation> ties;
  const Term& effect = *find_term(named.model.terms, named.added[i]);
  for (const std::optional<Term>& other : tied) {
    if (!other) continue;
    ties.push_back(
        separations(context.measurement, without_old, {effect, *other}, diagnosis.noise_floor_N).front());
  }
  return ties;
}

/// The ties of the effects of the steps with candidates that are none, and that the log can show.
std::vector<Separation> ties_of_named(const SelectionContext& context, const Diagnosis& diagnosis) {
  const Explanation named = named_explanation(context, diagnosis);
  std::vector<const Candidate*> others;
  for (const Candidate& one : diagnosis.candidates) {
    const bool shown = one.block_squared_error != diagnosis.baseline.block_squared_error;
    if (shown && !contains(named.model.terms, one.term.effect->text.id)) others.push_back(&one);
  }
  std::vector<Separation> ties;
  for (std::size_t i = 0; i < named.added.size(); ++i) {
    std::vector<Separation> of_one = ties_with(context, diagnosis, named, i, others);
    std::move(of_one.begin(), of_one.end(), std::back_inserter(ties));
  }
  return ties;
}

/// The candidates that reach most of the best reduction of the error, best first.
std::vector<const Candidate*> promising(const std::vector<Candidate>& candidates) {
  double best = kLeastReduction;
  for (const Candidate& one : candidates) best = std::max(best, one.error_reduction);
  const double enough = std::max(kLeastReduction, kMajority * best);
  std::vector<const Candidate*> most;
  for (const Candidate& one : candidates) {
    if (one.error_reduction >= enough) most.push_back(&one);
  }
  return most;
}

/// Whether most of the one force is in the other (in the mean square). Two that explain the same share of the
/// error by forces that have nothing in common are no tie: neither takes the place of the other.
bool is_mostly_the_same(const Separation& pair) {
  return squared(std::cos(pair.angle_deg * std::numbers::pi / 180.0)) > kMajority;
}

/// The ties of candidates, each alone, where no effect is named.
std::vector<Separation> ties_of_candidates(const SelectionContext& context, const Diagnosis& diagnosis) {
  const std::vector<const Candidate*> all = promising(diagnosis.candidates);
  std::vector<Explanation> models(all.size());
  parallel_for(all.size(), [&](std::size_t i) { models[i] = alone(context, diagnosis, *all[i]); });
  std::vector<Separation> ties;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const bool supported =
          is_supported(all[i]->criterion_difference) || is_supported(all[j]->criterion_difference);
      if (!supported || !is_tie(context, models[i], models[j])) continue;
      Separation pair = separations(context.measurement, diagnosis.baseline, {all[i]->term, all[j]->term},
                                    diagnosis.noise_floor_N)
                            .front();
      if (is_mostly_the_same(pair)) ties.push_back(std::move(pair));
    }
  }
  return ties;
}

void state_at(std::vector<Candidate>& candidates, const std::string& effect, const std::string& other) {
  for (Candidate& candidate : candidates) {
    if (candidate.term.id() == effect) candidate.confounded_with.push_back(other);
  }
}

}  // namespace

void list_ties(const SelectionContext& context, Diagnosis& diagnosis) {
  const bool named = diagnosis.steps.size() > 1;
  diagnosis.cannot_separate =
      named ? ties_of_named(context, diagnosis) : ties_of_candidates(context, diagnosis);
  std::stable_sort(diagnosis.cannot_separate.begin(), diagnosis.cannot_separate.end(),
                   [](const auto& a, const auto& b) { return a.angle_deg < b.angle_deg; });
  for (const Separation& pair : diagnosis.cannot_separate) {
    state_at(diagnosis.candidates, pair.effect, pair.other);
    state_at(diagnosis.candidates, pair.other, pair.effect);
  }
  std::erase_if(diagnosis.cannot_show, [&](const Visibility& one) {
    return std::any_of(diagnosis.cannot_separate.begin(), diagnosis.cannot_separate.end(),
                       [&](const Separation& pair) { return pair.other == one.effect; });
  });
}

std::string tie_text(const std::string& effect, const std::vector<std::string>& others) {
  return fmt::format("cannot tell {} from {}", effect, fmt::join(others, " or "));
}

std::string tie_text(const std::string& effect, const std::string& other, double angle_deg) {
  return fmt::format("{} ({}s {:.1f} degrees apart)", tie_text(effect, {other}), force_word(), angle_deg);
}

}  // namespace slipstack::workbench
