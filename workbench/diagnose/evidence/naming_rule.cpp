// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/naming_rule.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/alternatives/cause_forms.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"

namespace slipstack::workbench {
namespace {

/// The effect of `these` that `those` do not have; empty unless it is one.
std::string only_in(const std::vector<std::string>& these, const std::vector<std::string>& those) {
  std::string only;
  for (const std::string& id : these) {
    if (std::find(those.begin(), those.end(), id) != those.end()) continue;
    if (!only.empty()) return {};
    only = id;
  }
  return only;
}

/// Whether `simple` has a special case of an effect of `general` in its place, and is the same otherwise.
bool is_special_case(const Explanation& simple, const Explanation& general) {
  const std::string effect = only_in(general.added, simple.added);
  const std::string special = only_in(simple.added, general.added);
  return !effect.empty() && !special.empty() &&
         find_term(general.model.terms, effect)->effect->traits.special_case.id == special;
}

/// Whether an explanation is as good as one with a more general effect: that lowers the error by nothing
/// worth a name, or by no more than clocks and sensors err.
bool suffices(const SelectionContext& context, const Explanation& simple, const Explanation& general) {
  if (!is_special_case(simple, general)) return false;
  const double simple_N = simple.model.holdout_rmse_N;
  const double general_N = general.model.holdout_rmse_N;
  return !is_worth_a_name(simple_N, general_N) ||
         within_instruments(context.measurement, context.baseline, simple.model.terms, general.model.terms,
                            explained_N2(simple_N, general_N));
}

/// Whether `one` has an effect where `other` has a cause outside the catalogue, which no controller can
/// compensate, and is as good by the criterion, or far better on unseen data: it leaves less than half of the
/// mean square. The criterion, which is of the training data, may prefer a curve of many values that the
/// correlation of its own residual makes cheap.
bool outdoes_cause(const SelectionContext& context, const Explanation& one, const Explanation& other) {
  const std::string effect = only_in(one.added, other.added);
  const std::string cause = only_in(other.added, one.added);
  return !effect.empty() && !cause.empty() &&
         !is_outside_catalogue(*find_term(one.model.terms, effect)->effect) &&
         is_outside_catalogue(*find_term(other.model.terms, cause)->effect) &&
         (squared(one.model.holdout_rmse_N) < kMajority * squared(other.model.holdout_rmse_N) ||
          !is_supported(context.criterion.difference(other.model, one.model)));
}

}  // namespace

bool is_better(const SelectionContext& context, const Explanation& one, const Explanation& other) {
  if (suffices(context, one, other)) return true;
  if (suffices(context, other, one)) return false;
  if (outdoes_cause(context, one, other)) return true;
  if (outdoes_cause(context, other, one)) return false;
  return context.criterion.difference(one.model, other.model) < 0.0;
}

bool is_named_over(const SelectionContext& context, const Explanation& one, const Explanation& other) {
  if (suffices(context, other, one)) return false;
  const auto lowered = [](const Explanation& before, const Explanation& after) {
    return reduction(before.model.block_squared_error, after.model.block_squared_error);
  };
  const bool leaves_less = is_special_case(one, other) ? !is_above_chance(lowered(one, other))
                                                       : is_significant(lowered(other, one));
  return leaves_less && is_supported(context.criterion.difference(one.model, other.model));
}

bool is_tie(const SelectionContext& context, const Explanation& one, const Explanation& other) {
  return !is_named_over(context, one, other) && !is_named_over(context, other, one);
}

void sort_by_criterion(const SelectionContext& context, std::vector<Explanation>& all) {
  if (all.size() < 2) return;
  std::vector<const FittedModel*> models;
  models.reserve(all.size());
  for (const Explanation& one : all) models.push_back(&one.model);
  const std::vector<double> criteria = context.criterion.of(models);
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return criteria[a] < criteria[b]; });
  std::vector<Explanation> sorted;
  sorted.reserve(all.size());
  for (const std::size_t i : order) sorted.push_back(std::move(all[i]));
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (suffices(context, sorted[i], sorted.front()) || outdoes_cause(context, sorted[i], sorted.front())) {
      std::rotate(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(i),
                  sorted.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    }
  }
  all = std::move(sorted);
}

bool is_above_floor(const Measurement& measurement, const FittedModel& model) {
  return model.holdout_rmse_N >= kUncertainFloor * measurement.noise_floor_N();
}

bool is_improvement(const SelectionContext& context, const Explanation& before, const Explanation& after) {
  return is_worth_a_name(before.model.holdout_rmse_N, after.model.holdout_rmse_N) &&
         is_supported(context.criterion.difference(after.model, before.model)) &&
         is_above_floor(context.measurement, before.model);
}

bool is_step(const SelectionContext& context, const Explanation& before, const Explanation& after) {
  const double step_N2 = explained_N2(before.model.holdout_rmse_N, after.model.holdout_rmse_N);
  return is_improvement(context, before, after) &&
         !is_too_small(context.measurement, context.baseline, before.model.terms, after.model.terms, step_N2);
}

}  // namespace slipstack::workbench
