// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/seldom_negative.h"

#include <cstddef>
#include <utility>

#include "workbench/base/statistics.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/fit_gains.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

bool is_negative(const Term& term, int gain) {
  return gain >= 0 && term.gains[static_cast<std::size_t>(gain)] < 0.0;
}

void forbid_negative(Term& term) {
  const auto gain = static_cast<std::size_t>(term.effect->traits.plausible.seldom_negative);
  for (std::size_t i = gain; i < term.gains.size(); i += term.gains_per_set())
    term.gains[i] = term.lower[i] = 0.0;
}

}  // namespace

bool is_doubtfully_negative(const Measurement& measurement, const FittedModel& baseline,
                            const FittedModel& model, const Term& term) {
  const int gain = term.effect->traits.plausible.seldom_negative;
  if (!is_negative(term, gain)) return false;
  Terms alone = baseline.terms;
  alone.push_back(term);
  if (!is_negative(fit_gains(measurement, std::move(alone), &baseline).terms.back(), gain)) return true;
  Terms other = model.terms;
  for (Term& one : other) {
    if (one.effect == term.effect) forbid_negative(one);
  }
  const EffectDescription& payload = effect_with_role(Role::added_mass);
  if (!mass_is_free(other) && !contains(other, payload.text.id))
    other.push_back(make_term(measurement, payload));
  const double others_N = fit_gains(measurement, std::move(other), &model).holdout_rmse_N;
  return squared(model.holdout_rmse_N) > kMajority * squared(others_N);
}

FittedModel without_doubtful_negatives(const Measurement& measurement, const FittedModel& baseline,
                                       FittedModel model) {
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    if (!is_doubtfully_negative(measurement, baseline, model, model.terms[i])) continue;
    Terms terms = model.terms;
    forbid_negative(terms[i]);
    model = fit_gains(measurement, std::move(terms), &model);
  }
  return model;
}

}  // namespace slipstack::workbench
