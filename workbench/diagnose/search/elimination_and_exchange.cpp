// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/search/elimination_and_exchange.h"

#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/diagnose/alternatives/causes.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/diagnose/search/forward_selection.h"
#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {
namespace {

/// An effect is tried in place of another when, alone, it explains this share of what the other explains
/// alone, and it is fitted in full when, to first order, its error is at most this multiple of the other's:
/// an effect of fewer parameters may leave somewhat more. Both chosen: they only save fits.
constexpr double kShareAlone = 0.5;
constexpr double kNearEnough = 1.05;

std::vector<std::string> with_other(std::vector<std::string> added, const std::string& old,
                                    const std::string& other) {
  for (std::string& id : added) {
    if (id == old) id = other;
  }
  return added;
}

/// The trials of effects that may take the place of the effect `old`, those worth a fit.
std::vector<Trial> replacements(const SelectionContext& context, const std::vector<Trial>& alone,
                                const Explanation& explanation, const std::string& old,
                                const FittedModel& without_old) {
  const auto explained = [&](const Trial& trial) {
    return explained_N2(context.baseline.holdout_rmse_N, trial.holdout_rmse_N);
  };
  const Trial* own = find_trial(alone, old);
  if (own == nullptr) return {};
  std::vector<const EffectDescription*> others;
  for (const Trial& other : alone) {
    if (!contains(explanation.model.terms, other.term.effect->text.id) &&
        explained(other) >= kShareAlone * explained(*own)) {
      others.push_back(other.term.effect);
    }
  }
  std::vector<Trial> trials(others.size());
  parallel_for(trials.size(),
               [&](std::size_t i) { trials[i] = try_anew(context.measurement, without_old, *others[i]); });
  std::erase_if(trials, [&](const Trial& trial) {
    return trial.holdout_rmse_N > kNearEnough * explanation.model.holdout_rmse_N;
  });
  return trials;
}

}  // namespace

void drop_superfluous(const SelectionContext& context, Explanation& explanation) {
  for (std::size_t i = 0; i < explanation.added.size();) {
    std::vector<std::string> added = explanation.added;
    added.erase(added.begin() + static_cast<std::ptrdiff_t>(i));
    FittedModel model = context.baseline;
    if (!added.empty()) {
      model = fit_gains(context.measurement, without(explanation.model.terms, explanation.added[i]),
                        &explanation.model);
      model = refine_shapes_in_turn(context.measurement, std::move(model), {15});
      model = with_causes_found_again(context.measurement, std::move(model));
    }
    Explanation fewer{std::move(model), std::move(added)};
    if (is_step(context, fewer, explanation)) {
      ++i;
    } else {
      explanation = std::move(fewer);
      i = 0;  // what was needed beside the dropped one may no longer be
    }
  }
}

void exchange_effects(const SelectionContext& context, const std::vector<Trial>& alone,
                      Explanation& explanation) {
  for (std::size_t i = 0; i < explanation.added.size(); ++i) {
    const std::string old = explanation.added[i];
    const FittedModel without_old =
        fit_gains(context.measurement, without(explanation.model.terms, old), &explanation.model);
    for (const Trial& trial : replacements(context, alone, explanation, old, without_old)) {
      FittedModel model = fit_gains(context.measurement, trial.terms, &without_old);
      model = refine_shapes_in_turn(context.measurement, std::move(model), {15});
      model = with_causes_found_again(context.measurement, std::move(model));
      Explanation replaced{std::move(model),
                           with_other(explanation.added, explanation.added[i], trial.term.id())};
      if (is_better(context, replaced, explanation) &&
          !is_implausible(context.measurement, context.baseline, replaced.model)) {
        explanation = std::move(replaced);
      }
    }
  }
}

}  // namespace slipstack::workbench
