// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/search/growth.h"

#include <algorithm>
#include <atomic>
#include <tuple>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/model/effects/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// What does not repeat twice within the stroke is not seen to repeat.
bool too_coarse(const EffectDescription& effect, double stroke_m) {
  return std::any_of(effect.shapes.begin(), effect.shapes.end(), [&](const ShapeSpec& shape) {
    return shape.kind == ShapeKind::pitch && 2.0 * static_cast<double>(shape.lower) > stroke_m;
  });
}

/// Whether the effect would be the same column as one in the model, under another name; or is none of this
/// axis: a log that declares a mass of zero says that inertia does not count, so nothing swings either.
bool says_nothing_new(const Measurement& measurement, const Terms& terms, const EffectDescription& effect) {
  const bool weightless = measurement.log().mass_kg && *measurement.log().mass_kg == 0.0;
  if (weightless && (effect.has_role(Role::resonance) || effect.has_role(Role::added_mass))) return true;
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

/// Effects worth trying on top of `terms`, the user's own first: these take longest, so the processors share
/// the work well.
std::vector<const EffectDescription*> effects_to_try(const Measurement& measurement,
                                                     const DiagnoseOptions& options, const Terms& terms) {
  const auto [lowest, highest] =
      std::minmax_element(measurement.position_m().begin(), measurement.position_m().end());
  const double stroke_m = *highest - *lowest;
  std::vector<const EffectDescription*> effects;
  for (const EffectDescription* effect : options.user_effects) {
    if (!contains(terms, effect->text.id)) effects.push_back(effect);
  }
  for (const EffectDescription* effect : wanted_effects(options)) {
    if (contains(terms, effect->text.id) || too_coarse(*effect, stroke_m) ||
        says_nothing_new(measurement, terms, *effect)) {
      continue;
    }
    effects.push_back(effect);
  }
  return effects;
}

/// A trial on top of an explanation: from the shapes that the first level found, unless they are pitches and
/// frequencies, which another residual may show elsewhere.
Trial retry(const Measurement& measurement, const FittedModel& from, const EffectDescription& effect,
            const std::vector<Trial>& alone) {
  const Trial* first = find_trial(alone, effect.text.id);
  const bool elsewhere = std::any_of(effect.shapes.begin(), effect.shapes.end(), [](const ShapeSpec& shape) {
    return shape.kind == ShapeKind::pitch || shape.kind == ShapeKind::frequency ||
           shape.kind == ShapeKind::user_defined;
  });
  const bool known = first != nullptr && !elsewhere;
  return try_effect(measurement, from, effect, {20}, known ? &first->term.shapes : nullptr);
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

/// What promises less to first order is not fitted in full.
constexpr double kLeastPromising = 0.015;

}  // namespace

std::vector<Attempt> try_effects(const Measurement& measurement, const DiagnoseOptions& options,
                                 const std::vector<Explanation>& beam, const std::vector<Trial>* alone) {
  std::vector<Attempt> attempts;
  for (const Explanation& from : beam) {
    for (const EffectDescription* effect : effects_to_try(measurement, options, from.model.terms))
      attempts.push_back({&from, effect, {}});
  }
  std::atomic<std::size_t> done{0};
  parallel_for(attempts.size(), [&](std::size_t i) {
    Attempt& one = attempts[i];
    one.trial = alone == nullptr ? try_effect(measurement, one.from->model, *one.effect, {})
                                 : retry(measurement, one.from->model, *one.effect, *alone);
    const std::size_t finished = ++done;
    options.report(alone == nullptr ? "try every effect" : "try every effect on top",
                   static_cast<double>(finished) / static_cast<double>(attempts.size()));
  });
  // By error, then by name: effects that do nothing tie, whatever the order of the catalogue.
  std::sort(attempts.begin(), attempts.end(), [](const Attempt& a, const Attempt& b) {
    return std::tuple(a.trial.holdout_rmse_N, std::string_view(a.effect->text.id), a.from) <
           std::tuple(b.trial.holdout_rmse_N, std::string_view(b.effect->text.id), b.from);
  });
  return attempts;
}

std::vector<Explanation> fit_best(const Measurement& measurement, std::vector<Attempt> attempts,
                                  std::size_t most) {
  std::vector<Attempt> distinct;
  for (Attempt& attempt : attempts) {
    if (attempt.trial.holdout_rmse_N > (1.0 - kLeastPromising) * attempt.from->model.holdout_rmse_N) continue;
    const bool seen = std::any_of(distinct.begin(), distinct.end(), [&](const Attempt& other) {
      return same_set(added_by(other), added_by(attempt));
    });
    if (!seen) distinct.push_back(std::move(attempt));
    if (distinct.size() == most) break;
  }
  std::vector<Explanation> grown(distinct.size());
  parallel_for(distinct.size(), [&](std::size_t i) {
    grown[i].model = fit_gains(measurement, distinct[i].trial.terms, &distinct[i].from->model);
    grown[i].added = added_by(distinct[i]);
  });
  return grown;
}

const Trial* find_trial(const std::vector<Trial>& trials, std::string_view id) {
  const auto found = std::find_if(trials.begin(), trials.end(),
                                  [&](const Trial& one) { return id == one.term.effect->text.id; });
  return found == trials.end() ? nullptr : &*found;
}

}  // namespace slipstack::workbench
