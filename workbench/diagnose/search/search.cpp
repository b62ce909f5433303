// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/search/search.h"

#include <algorithm>
#include <utility>

#include "workbench/diagnose/evidence/repeats.h"
#include "workbench/model/effects/effect_registry.h"

namespace slipstack::workbench {
namespace {

bool has_dry_friction(const FittedModel& model) {
  return std::any_of(model.terms.begin(), model.terms.end(),
                     [](const Term& term) { return term.effect->acts_as(Acts::dry); });
}

int parameters(const FittedModel& model) {
  int count = 0;
  for (const Term& term : model.terms) count += term.effect->parameter_count();
  return count;
}

/// The explanation of the lowest held-out error, unless one of fewer parameters explains as much of the error
/// of `before`.
const Explanation& choose(const SelectionContext& context, const std::vector<Explanation>& all,
                          const FittedModel& before) {
  const Explanation& best = *std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.model.holdout_rmse_N < b.model.holdout_rmse_N;
  });
  const Explanation* chosen = &best;
  for (const Explanation& other : all) {
    const bool as_good = explains_as_well(context, other.model, best.model, before);
    const int fewer = parameters(chosen->model) - parameters(other.model);
    const bool better = other.model.holdout_rmse_N < chosen->model.holdout_rmse_N;
    if (as_good && (fewer > 0 || (fewer == 0 && better))) chosen = &other;
  }
  return *chosen;
}

/// Whether, of a pair whose first effect was not significant alone, the second is significant beside the
/// first; prune() tests the first beside the second. An effect that is significant alone was tested when it
/// was added.
bool needs_both(const SelectionContext& context, const std::vector<Explanation>& beam,
                const Explanation& winner, const Explanation& best) {
  if (!best.added.empty() || winner.added.size() < 2) return true;
  const auto first = std::find_if(beam.begin(), beam.end(), [&](const Explanation& one) {
    return one.added.front() == winner.added.front();
  });
  return first != beam.end() && is_significant(context, first->model, winner.model);
}

/// Explanations that are kept from level to level. Chosen on the blind bench.
constexpr std::size_t kBeam = 3;
/// An explanation is kept only if it explains this share of what the best of its size explains. Chosen.
constexpr double kShareToKeep = 0.5;

/// Keeps the best explanations, if they explain enough compared with the best.
void keep_best(std::vector<Explanation>& all, const FittedModel& baseline) {
  std::sort(all.begin(), all.end(),
            [](const auto& a, const auto& b) { return a.model.holdout_rmse_N < b.model.holdout_rmse_N; });
  if (all.size() > kBeam) all.resize(kBeam);
  const auto explained = [&](const Explanation& one) {
    return explained_N2(baseline.holdout_rmse_N, one.model.holdout_rmse_N);
  };
  const double best = explained(all.front());
  std::erase_if(all, [&](const Explanation& one) { return explained(one) < kShareToKeep * best; });
}

/// Adds every further effect to every explanation of the beam: all to first order, the best fitted in full.
/// The trials of the first level are stored, since all of them are reported as candidates.
std::vector<Explanation> grow(const Measurement& measurement, const DiagnoseOptions& options,
                              const std::vector<Explanation>& beam, bool first, Found& found) {
  std::vector<Attempt> attempts = try_effects(measurement, options, beam, first ? nullptr : &found.alone);
  if (first) {
    found.alone.reserve(attempts.size());
    for (const Attempt& attempt : attempts) found.alone.push_back(attempt.trial);
  }
  std::vector<Explanation> grown = fit_best(measurement, std::move(attempts), 2 * kBeam);
  if (first) found.first_level = grown;
  return grown;
}

/// Stribeck friction must explain this share of what a lag over the deflection of the bristle explains to
/// take its place. Chosen on logs of tests/bench/blind/stranger_generator.py.
constexpr double kShareOfDeflection = 0.75;

/// Whether the lag in the model is Stribeck friction of a bristle, delayed by the deflection of the bristle.
bool lag_comes_from_bristle(const Found& found, const FittedModel& baseline, const FittedModel& model) {
  const EffectDescription& memory = effect_with_role(Role::friction_memory);
  const Trial* lag = find_trial(found.alone, memory.text.id);
  const Trial* stribeck = find_trial(found.alone, memory.traits.special_case.id);
  return lag != nullptr && stribeck != nullptr && lag_is_bristle_deflection(model) &&
         explained_N2(baseline.holdout_rmse_N, stribeck->holdout_rmse_N) >=
             kShareOfDeflection * explained_N2(baseline.holdout_rmse_N, lag->holdout_rmse_N);
}

/// Replaces the explanation of `next` that added these effects by `now`.
void replace_in_beam(const Explanation& now, const std::vector<std::string>& added,
                     std::vector<Explanation>& next) {
  for (Explanation& one : next) {
    if (one.added == added) one = now;
  }
}

/// Replaces Stribeck friction by frictional lag in the explanation and in the beam, where the lag explains
/// more than Stribeck friction can. The lag is searched globally again, because its shapes were found while
/// the other effects were missing.
void replace_stribeck_by_lag(const Measurement& measurement, const FittedModel& baseline, const Found& found,
                             Explanation& best, std::vector<Explanation>& next) {
  const EffectDescription& lag = effect_with_role(Role::friction_memory);
  const std::string special_case = lag.traits.special_case.id;
  const auto stribeck = std::find(best.added.begin(), best.added.end(), special_case);
  if (stribeck == best.added.end()) return;
  const FittedModel before = fit_gains(measurement, without(best.model.terms, special_case), &best.model);
  const Trial trial = try_effect(measurement, before, lag, {});
  FittedModel model = fit_gains(measurement, trial.terms, &before);
  if (lag_comes_from_bristle(found, baseline, model) ||
      explains_as_well(found.context, best.model, model, before)) {
    return;
  }
  const std::vector<std::string> was = best.added;
  best.model = refine_shapes_in_turn(measurement, std::move(model), {20});
  best.added[static_cast<std::size_t>(stribeck - best.added.begin())] = lag.id();
  replace_in_beam(best, was, next);
}

/// Adds a low pass to a delay, in the explanation and in the beam, before other effects are tried: the error
/// of a low pass that is modelled as a delay resembles a mode.
void add_low_pass_to_delay(const Measurement& measurement, Explanation& best,
                           std::vector<Explanation>& next) {
  if (!has_role(best.model.terms, Role::measurement_delay)) return;
  best.model = refine_delay(measurement, std::move(best.model));
  if (measurement_dynamics_of(best.model.terms).filter_s != 0.0) replace_in_beam(best, best.added, next);
}

/// Effects that are added at most. Chosen.
constexpr std::size_t kMostSteps = 5;
/// The search ends when the held-out error is below this multiple of the noise floor. Chosen.
constexpr double kAtFloor = 1.10;
/// Above this multiple of the noise floor, shapes are searched globally again: they were found while other
/// effects were missing. Chosen.
constexpr double kNearFloor = 1.20;

}  // namespace

Found search(const Measurement& measurement, const DiagnoseOptions& options, const FittedModel& baseline,
             const NoiseFloor& floor) {
  Found found{{baseline, {}},
              {baseline, floor, measurement.tick_s(), measurement.bandwidth_Hz(), baseline.holdout_rmse_N},
              {},
              {}};
  Explanation& best = found.best;
  SelectionContext& context = found.context;
  std::vector<Explanation> beam{best};
  for (std::size_t level = 0; level < kMostSteps; ++level) {
    std::vector<Explanation> next = grow(measurement, options, beam, level == 0, found);
    std::erase_if(next, [&](const Explanation& one) {
      return (has_no_true_mode(one.model) && !has_no_true_mode(baseline)) ||
             lag_comes_from_bristle(found, baseline, one.model) ||
             ripple_not_supported(measurement, one.model, baseline.terms) ||
             (coulomb_joins_hysteresis(best.model, one.model) &&
              !is_significant(context, best.model, one.model));
    });
    if (next.empty()) break;
    const Explanation& winner = choose(context, next, best.model);
    if (is_significant(context, best.model, winner.model) && needs_both(context, beam, winner, best)) {
      if (!has_dry_friction(best.model) && has_dry_friction(winner.model)) {
        context.reference_error_N = winner.model.holdout_rmse_N;
      }
      best = winner;
      best.model = refine_shapes_in_turn(measurement, std::move(best.model), {20});
      if (level > 0 && best.model.holdout_rmse_N > kNearFloor * floor.of(best.model.terms)) {
        best.model = search_globally(measurement, std::move(best.model), best.added);
        replace_stribeck_by_lag(measurement, baseline, found, best, next);
      }
      add_low_pass_to_delay(measurement, best, next);
      if (best.model.holdout_rmse_N < kAtFloor * floor.of(best.model.terms)) break;
    } else if (level > 0 || !is_promising(context, winner.model)) {
      break;
    }
    keep_best(next, baseline);
    beam = std::move(next);
  }
  return found;
}

}  // namespace slipstack::workbench
