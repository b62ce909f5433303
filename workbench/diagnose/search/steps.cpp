// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/search/steps.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "workbench/diagnose/candidates.h"
#include "workbench/diagnose/evidence/evidence.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/diagnose/search/forward_selection.h"
#include "workbench/estimate/uncertainty/held_out_error.h"
#include "workbench/estimate/uncertainty/standard_errors.h"

namespace slipstack::workbench {
namespace {

/// Moves the effect that lowers the error most on top of `terms`, with the shapes of `full`, to the front.
void put_next(const Measurement& measurement, const Terms& terms, const FittedModel& full,
              std::span<std::string> order) {
  double least_N = HUGE_VAL;
  for (std::string& id : order) {
    Terms more = terms;
    more.push_back(*find_term(full.terms, id));
    const double error_N = fit_gains(measurement, std::move(more), &full).holdout_rmse_N;
    if (error_N >= least_N) continue;
    least_N = error_N;
    std::swap(order.front(), id);
  }
}

const Candidate& candidate_of(const Diagnosis& diagnosis, const std::string& id) {
  return *std::find_if(diagnosis.candidates.begin(), diagnosis.candidates.end(),
                       [&](const Candidate& candidate) { return candidate.term.id() == id; });
}

/// Moves the first effect that is plausible alone to the front. What is implausible alone was chosen for what
/// another leaves, however little it would leave alone.
void put_plausible_first(const Measurement& measurement, const Diagnosis& diagnosis,
                         std::vector<std::string>& order) {
  if (order.size() < 2) return;
  const auto first = std::find_if(order.begin(), order.end(), [&](const std::string& id) {
    return !is_implausible_alone(measurement, diagnosis.baseline, candidate_of(diagnosis, id));
  });
  if (first != order.end()) std::rotate(order.begin(), first, std::next(first));
}

/// Of two fits of the same effects the one that is closer to the training data.
FittedModel better_fit(FittedModel one, FittedModel other) {
  return other.train_rmse_N < one.train_rmse_N ? std::move(other) : std::move(one);
}

/// Whether a step only gives a part of the model's force a name of its own: a payload beside a mode is the
/// rigid mass of that (mass_and_mode.h).
bool only_names(const Step& step) {
  return find_term(step.terms, step.effect)->effect->has_role(Role::added_mass) &&
         has_role(step.terms, Role::resonance);
}

/// Whether the last step lowers the error of the one before it as an effect that is named must.
bool last_is_significant(const std::vector<Step>& steps) {
  const Step& before = steps[steps.size() - 2];
  return only_names(steps.back()) ||
         is_significant(reduction(before.block_squared_error, steps.back().block_squared_error));
}

}  // namespace

void list_steps(const SelectionContext& context, const Explanation& best, Diagnosis& diagnosis) {
  const Measurement& measurement = context.measurement;
  diagnosis.steps.push_back({"baseline", diagnosis.baseline.holdout_rmse_N, diagnosis.baseline.forward_rmse_N,
                             diagnosis.baseline.block_squared_error, 0.0, "", diagnosis.baseline.terms});
  diagnosis.best = diagnosis.baseline;
  std::vector<std::string> order;
  for (const Candidate& candidate : diagnosis.candidates) {
    const std::string id = candidate.term.id();
    if (std::find(best.added.begin(), best.added.end(), id) != best.added.end()) order.push_back(id);
  }
  put_plausible_first(measurement, diagnosis, order);
  Terms terms = diagnosis.baseline.terms;
  FittedModel before = diagnosis.baseline;
  const FittedModel known = order.empty() ? best.model : with_standard_errors(measurement, best.model);
  // Alone, a mode has the payload in its rigid mass: then the step of the payload would explain nothing.
  const bool splits_mass =
      has_role(best.model.terms, Role::resonance) && has_role(best.model.terms, Role::added_mass);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool last = i + 1 == order.size();
    if (i > 0 && !last) put_next(measurement, terms, best.model, std::span(order).subspan(i));
    const Term& term = *find_term(best.model.terms, order[i]);
    terms.push_back(term);
    FittedModel model =
        last ? best.model
             : refine_shapes_in_turn(measurement, fit_gains(measurement, terms, &best.model), kRefinement);
    if (i == 0 && !last && !splits_mass)
      model = better_fit(std::move(model), fit_gains(measurement, candidate_of(diagnosis, order[0]).terms,
                                                     &diagnosis.baseline));
    if (!last) judge_on_unseen_data(measurement, model);
    diagnosis.steps.push_back({order[i], model.holdout_rmse_N, model.forward_rmse_N,
                               model.block_squared_error, context.criterion.difference(model, before),
                               evidence_of(known, order[i]), model.terms});
    if (i == 0) diagnosis.best = model;
    before = std::move(model);
  }
}

void drop_insignificant_steps(const Measurement& measurement, Diagnosis& diagnosis) {
  std::vector<Step>& steps = diagnosis.steps;
  const std::size_t found = steps.size();
  while (steps.size() > 1 && !last_is_significant(steps)) steps.pop_back();
  if (steps.size() == found) return;
  if (steps.size() == 1) diagnosis.best = diagnosis.baseline;
  if (steps.size() <= 2) {
    diagnosis.explained = diagnosis.best;
    return;
  }
  diagnosis.explained = fit_gains(measurement, steps.back().terms, &diagnosis.explained);
  diagnosis.explained.holdout_rmse_N = steps.back().holdout_rmse_N;
}

}  // namespace slipstack::workbench
