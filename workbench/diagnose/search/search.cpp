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
const Explanation& choose(const Yardstick& yardstick, const std::vector<Explanation>& all,
                          const FittedModel& before) {
  const Explanation& best = *std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.model.holdout_rmse_N < b.model.holdout_rmse_N;
  });
  const Explanation* chosen = &best;
  for (const Explanation& other : all) {
    const bool as_good = stands_for(yardstick, other.model, best.model, before);
    const int fewer = parameters(chosen->model) - parameters(other.model);
    const bool better = other.model.holdout_rmse_N < chosen->model.holdout_rmse_N;
    if (as_good && (fewer > 0 || (fewer == 0 && better))) chosen = &other;
  }
  return *chosen;
}

/// Whether the last of two effects, of which the first was not sure alone, earns its place beside it; prune()
/// asks that of the first. One that was sure was asked when it was added.
bool needs_both(const Yardstick& yardstick, const std::vector<Explanation>& beam, const Explanation& winner,
                const Explanation& best) {
  if (!best.added.empty() || winner.added.size() < 2) return true;
  const auto first = std::find_if(beam.begin(), beam.end(), [&](const Explanation& one) {
    return one.added.front() == winner.added.front();
  });
  return first != beam.end() && earned(yardstick, first->model, winner.model);
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
constexpr double kShareOfStretch = 0.75;

/// Whether the model's lag is Stribeck friction of a bristle, seen through its own stretch.
bool lag_is_of_bristle(const Found& found, const FittedModel& baseline, const FittedModel& model) {
  const Trial* lag = find_trial(found.alone, "frictional_lag");
  const Trial* stribeck = find_trial(found.alone, "stribeck");
  return lag != nullptr && stribeck != nullptr && lags_by_own_stretch(model) &&
         explained_N2(baseline.holdout_rmse_N, stribeck->holdout_rmse_N) >=
             kShareOfStretch * explained_N2(baseline.holdout_rmse_N, lag->holdout_rmse_N);
}

/// The search goes on from `now` instead of the explanation of `next` that added these effects.
void go_on_from(const Explanation& now, const std::vector<std::string>& added,
                std::vector<Explanation>& next) {
  for (Explanation& one : next) {
    if (one.added == added) one = now;
  }
}

/// The explanation with a lag for its Stribeck friction, where that explains what Stribeck friction cannot
/// stand for: the lag's shapes were found while the other effects were missing, and are searched anew. The
/// search goes on from there.
void go_on_with_lag(const Measurement& measurement, const FittedModel& baseline, const Found& found,
                    Explanation& best, std::vector<Explanation>& next) {
  const auto stribeck = std::find(best.added.begin(), best.added.end(), "stribeck");
  if (stribeck == best.added.end()) return;
  const FittedModel before = fit_gains(measurement, without(best.model.terms, "stribeck"), &best.model);
  const Trial trial = try_effect(measurement, before, *find_effect("frictional_lag"), {});
  FittedModel model = fit_gains(measurement, trial.terms, &before);
  if (lag_is_of_bristle(found, baseline, model) || stands_for(found.yardstick, best.model, model, before)) {
    return;
  }
  const std::vector<std::string> was = best.added;
  best.model = polish_shapes(measurement, std::move(model), {20});
  best.added[static_cast<std::size_t>(stribeck - best.added.begin())] = "frictional_lag";
  go_on_from(best, was, next);
}

/// A low pass beside a delay, before other effects are tried: what it leaves as a delay looks like a mode.
/// The search goes on from there.
void go_on_with_low_pass(const Measurement& measurement, Explanation& best, std::vector<Explanation>& next) {
  if (!contains(best.model.terms, "time_delay")) return;
  best.model = settle_lag(measurement, std::move(best.model));
  if (lag_of(best.model.terms).filter_s != 0.0) go_on_from(best, best.added, next);
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
  Yardstick& yardstick = found.yardstick;
  std::vector<Explanation> beam{best};
  for (std::size_t level = 0; level < kMostSteps; ++level) {
    std::vector<Explanation> next = grow(measurement, options, beam, level == 0, found);
    std::erase_if(next, [&](const Explanation& one) {
      return (has_no_true_mode(one.model) && !has_no_true_mode(baseline)) ||
             lag_is_of_bristle(found, baseline, one.model) ||
             ripple_not_borne_out(measurement, one.model, baseline.terms) ||
             (coulomb_joins_hysteresis(best.model, one.model) && !earned(yardstick, best.model, one.model));
    });
    if (next.empty()) break;
    const Explanation& winner = choose(yardstick, next, best.model);
    if (earned(yardstick, best.model, winner.model) && needs_both(yardstick, beam, winner, best)) {
      if (!has_dry_friction(best.model) && has_dry_friction(winner.model)) {
        yardstick.known_N = winner.model.holdout_rmse_N;
      }
      best = winner;
      best.model = polish_shapes(measurement, std::move(best.model), {20});
      if (level > 0 && best.model.holdout_rmse_N > kNearFloor * floor.of(best.model.terms)) {
        best.model = search_anew(measurement, std::move(best.model), best.added);
        go_on_with_lag(measurement, baseline, found, best, next);
      }
      go_on_with_low_pass(measurement, best, next);
      if (best.model.holdout_rmse_N < kAtFloor * floor.of(best.model.terms)) break;
    } else if (level > 0 || !promises(yardstick, winner.model)) {
      break;
    }
    keep_best(next, baseline);
    beam = std::move(next);
  }
  return found;
}

}  // namespace slipstack::workbench
