// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/simplify.h"

#include <utility>

namespace slipstack::workbench {
namespace {

/// An effect is tried in place of another when, alone, it explains this share of what the other explains
/// alone. Chosen: it only saves fits.
constexpr double kShareAlone = 0.5;

/// Whether `other` has fewer parameters than `own` and explains at least kShareAlone of what `own` explains.
bool may_replace(const FittedModel& baseline, const Trial& own, const Trial& other) {
  const auto explained = [&](const Trial& trial) {
    return explained_N2(baseline.holdout_rmse_N, trial.holdout_rmse_N);
  };
  return other.term.effect->parameter_count() < own.term.effect->parameter_count() &&
         explained(other) >= kShareAlone * explained(own);
}

/// With the simpler effect the explanation must explain this share of what it explained before. The error
/// alone does not decide: where much is left either way, an error that is hardly larger may explain far less.
constexpr double kShareInPlace = 0.9;

bool can_replace(const FittedModel& simpler, const FittedModel& model, const FittedModel& baseline) {
  return hardly_worse(simpler, model) &&
         explained_N2(baseline.holdout_rmse_N, simpler.holdout_rmse_N) >=
             kShareInPlace * explained_N2(baseline.holdout_rmse_N, model.holdout_rmse_N);
}

FittedModel fit_refined(const Measurement& measurement, Terms terms, const FittedModel& known) {
  return refine_shapes_in_turn(measurement, fit_gains(measurement, std::move(terms), &known), {15});
}

}  // namespace

void prune(const Measurement& measurement, const SelectionContext& context, Explanation& explanation) {
  for (std::size_t i = 0; explanation.added.size() > 1 && i < explanation.added.size();) {
    FittedModel fewer =
        fit_refined(measurement, without(explanation.model.terms, explanation.added[i]), explanation.model);
    if (is_significant(context, fewer, explanation.model)) {
      ++i;
    } else {
      explanation.model = std::move(fewer);
      explanation.added.erase(explanation.added.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  // If one effect of a pair is left, it must be significant alone.
  if (explanation.added.size() == 1 && !is_significant(context, context.baseline, explanation.model)) {
    explanation = {context.baseline, {}};
  }
}

void simplify(const Measurement& measurement, const SelectionContext& context,
              const std::vector<Trial>& alone, Explanation& explanation) {
  for (std::string& added : explanation.added) {
    const Trial* own = find_trial(alone, added);
    if (own == nullptr) continue;
    for (const Trial& other : alone) {
      if (contains(explanation.model.terms, other.term.effect->text.id) ||
          !may_replace(context.baseline, *own, other)) {
        continue;
      }
      Terms terms;
      for (const Term& term : explanation.model.terms)
        terms.push_back(term.id() == added ? other.term : term);
      FittedModel simpler = fit_refined(measurement, std::move(terms), explanation.model);
      if (!can_replace(simpler, explanation.model, context.baseline) &&
          !explains_as_well(context, simpler, explanation.model, context.baseline)) {
        continue;
      }
      explanation.model = std::move(simpler);
      added = other.term.id();
      own = &other;
    }
  }
}

}  // namespace slipstack::workbench
