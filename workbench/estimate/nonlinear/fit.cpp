// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/fit.h"

#include <algorithm>
#include <utility>

#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// The model with the shapes of one term searched and those of the others held: from `start`, or over the
/// whole ranges where it is null. Unchanged where that does not lower the held-out error.
FittedModel with_shapes_searched(const Measurement& measurement, FittedModel fitted, std::size_t t,
                                 const SearchEffort& effort, const std::vector<double>* start) {
  const EffectDescription& effect = *fitted.terms[t].effect;
  if (searched_shapes(measurement, effect).empty()) return fitted;
  const FittedModel base =
      linearised(measurement, without(fitted.terms, fitted.terms[t].id()), fitted.train_rmse_N, &fitted);
  Terms terms = fitted.terms;
  terms[t].shapes = try_effect(measurement, base, effect, effort, start).term.shapes;
  settle_pitch(measurement, terms[t]);
  FittedModel moved = fit_gains(measurement, std::move(terms), &fitted);
  if (moved.holdout_rmse_N < fitted.holdout_rmse_N) fitted = std::move(moved);
  return fitted;
}

}  // namespace

FittedModel fit_effects(const Measurement& measurement, const std::vector<std::string>& effects,
                        const SearchEffort& effort) {
  Terms fixed;
  std::vector<const EffectDescription*> searched;
  for (const std::string& id : effects) {
    const EffectDescription* effect = find_effect(id);
    if (searched_shapes(measurement, *effect).empty() && !effect->acts_as(Acts::dry_scale)) {
      fixed.push_back(term_for_log(measurement, *effect));
    } else {
      searched.push_back(effect);
    }
  }
  FittedModel fitted = fit_gains(measurement, fixed);
  // Dry friction first: effects that modulate it can only be fitted once it is there.
  std::stable_sort(searched.begin(), searched.end(), [](const auto* a, const auto* b) {
    return a->acts_as(Acts::dry) && !b->acts_as(Acts::dry);
  });
  for (const EffectDescription* effect : searched) {
    fitted = fit_gains(measurement, try_effect(measurement, fitted, *effect, effort).terms, &fitted);
  }
  if (searched.size() > 1) fitted = refine_shapes_in_turn(measurement, std::move(fitted), effort);
  // In the order in which the effects were given.
  Terms ordered;
  for (const std::string& id : effects) ordered.push_back(*find_term(fitted.terms, id));
  fitted = fit_gains(measurement, std::move(ordered), &fitted);
  return searched.empty() ? fitted : refine_all_shapes(measurement, std::move(fitted));
}

FittedModel refine_shapes_in_turn(const Measurement& measurement, FittedModel fitted,
                                  const SearchEffort& effort) {
  for (std::size_t t = 0; t < fitted.terms.size(); ++t) {
    const std::vector<double> here = fitted.terms[t].shapes;
    fitted = with_shapes_searched(measurement, std::move(fitted), t, effort, &here);
  }
  return fitted;
}

FittedModel search_globally(const Measurement& measurement, FittedModel fitted,
                            const std::vector<std::string>& effects) {
  for (std::size_t t = 0; t < fitted.terms.size(); ++t) {
    if (std::find(effects.begin(), effects.end(), fitted.terms[t].id()) == effects.end()) continue;
    fitted = with_shapes_searched(measurement, std::move(fitted), t, {}, nullptr);
  }
  return fitted;
}

}  // namespace slipstack::workbench
