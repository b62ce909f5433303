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

/// The lowest held-out error, unless something simpler explains as much of what `before` left.
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

/// Whether the last of two effects, of which the first was not sure alone, earns its place beside it; prune()
/// asks that of the first. One that was sure was asked when it was added.
bool needs_both(const SelectionContext& context, const std::vector<Explanation>& beam,
                const Explanation& winner, const Explanation& best) {
  if (!best.added.empty() || winner.added.size() < 2) return true;
  const auto first = std::find_if(beam.begin(), beam.end(), [&](const Explanation& one) {
    return one.added.front() == winner.added.front();
  });
  return first != beam.end() && is_significant(context, first->model, winner.model);
}

constexpr std::size_t kBeam = 3;
/// An explanation goes on when it explains this share of what the best of its size does.
constexpr double kShareToGoOn = 0.5;

/// What goes on: the best few, as long as they explain a fair part of what the best does.
void keep_best(std::vector<Explanation>& all, const FittedModel& baseline) {
  std::sort(all.begin(), all.end(),
            [](const auto& a, const auto& b) { return a.model.holdout_rmse_N < b.model.holdout_rmse_N; });
  if (all.size() > kBeam) all.resize(kBeam);
  const auto explained = [&](const Explanation& one) {
    return explained_N2(baseline.holdout_rmse_N, one.model.holdout_rmse_N);
  };
  const double best = explained(all.front());
  std::erase_if(all, [&](const Explanation& one) { return explained(one) < kShareToGoOn * best; });
}

/// Every explanation of the beam with every further effect: screened to first order, the best of each fitted
/// in full. The first level is remembered, since all of it is listed.
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

/// Of what a lag by the bristle's own stretch explains, what Stribeck friction must to have its name.
constexpr double kShareOfDeflection = 0.75;

/// Whether the model's lag is Stribeck friction of a bristle, seen through its own stretch.
bool lag_comes_from_bristle(const Found& found, const FittedModel& baseline, const FittedModel& model) {
  const EffectDescription& memory = effect_with_role(Role::friction_memory);
  const Trial* lag = find_trial(found.alone, memory.text.id);
  const Trial* stribeck = find_trial(found.alone, memory.traits.special_case.id);
  return lag != nullptr && stribeck != nullptr && lag_is_bristle_deflection(model) &&
         explained_N2(baseline.holdout_rmse_N, stribeck->holdout_rmse_N) >=
             kShareOfDeflection * explained_N2(baseline.holdout_rmse_N, lag->holdout_rmse_N);
}

/// The search goes on from `now` instead of the explanation of `next` that added these effects.
void replace_in_beam(const Explanation& now, const std::vector<std::string>& added,
                     std::vector<Explanation>& next) {
  for (Explanation& one : next) {
    if (one.added == added) one = now;
  }
}

/// The explanation with a lag for its Stribeck friction, where that explains what Stribeck friction cannot
/// stand for: the lag's shapes were found while the other effects were missing, and are searched anew. The
/// search goes on from there.
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

/// A low pass beside a delay, before other effects are tried: what it leaves as a delay looks like a mode.
/// The search goes on from there.
void add_low_pass_to_delay(const Measurement& measurement, Explanation& best,
                           std::vector<Explanation>& next) {
  if (!has_role(best.model.terms, Role::measurement_delay)) return;
  best.model = refine_delay(measurement, std::move(best.model));
  if (measurement_dynamics_of(best.model.terms).filter_s != 0.0) replace_in_beam(best, best.added, next);
}

constexpr std::size_t kMostSteps = 5;
/// Held-out errors this near to the floor end the search.
constexpr double kAtFloor = 1.10;
/// Beyond this, shapes found while the other effects were missing are searched anew.
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
