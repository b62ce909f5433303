// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/known_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "workbench/base/text.h"
#include "workbench/estimate/nonlinear/checks.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/long_logs/log_search.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

// Assumed where there is neither log nor model. Chosen.
constexpr double kAssumedMass_kg = 10.0;
constexpr double kAssumedFriction_N = 10.0;
constexpr double kAssumedNoise = 0.01;  ///< of the friction
constexpr double kAssumedEncoder_m = 1e-7;

/// The model of an axis where nothing is known: mass, and the exponential virgin curve of rolling guideways.
Terms assumed_model() {
  Term inertia;
  inertia.effect = &effect_with_role(Role::inertia);
  inertia.gains = inertia.lower = inertia.upper = {kAssumedMass_kg};
  Term hysteresis;
  hysteresis.effect = &effect_with_role(Role::hysteresis);
  constexpr std::size_t kElements = 10;
  const auto capacity = static_cast<std::size_t>(hysteresis.effect->gain_count);
  hysteresis.shapes = slip_distances(1e-7, 1e-4, kElements, capacity);
  hysteresis.gains.assign(capacity, 0.0);
  for (std::size_t i = 0; i < kElements; ++i) {
    hysteresis.gains[i] = kAssumedFriction_N / kElements / hysteresis.shapes[i];
  }
  hysteresis.lower.assign(capacity, 0.0);
  hysteresis.upper.assign(capacity, static_cast<double>(kUnbounded));
  return {inertia, hysteresis};
}

Term unknown_term(const EffectDescription& effect) {
  Term term;
  term.effect = &effect;
  return term;
}

/// The baseline on the logs, without the effects that are planned for.
FittedModel base_of(const PlanRequest& request, const std::vector<std::string>& ids, const Model& model,
                    const Measurement& measurement) {
  const auto planned = [&](const std::string& id) {
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  };
  if (!request.model.empty()) {
    Terms terms = terms_on(measurement, model.terms);
    std::erase_if(terms, [&](const Term& term) { return planned(term.id()); });
    return fit_gains(measurement, std::move(terms));
  }
  std::vector<std::string> baseline =
      request.baseline.empty() ? default_baseline() : parse_effects(request.baseline);
  std::erase_if(baseline, planned);
  if (baseline.empty()) throw UsageError("--effects: nothing is left beside those of --for; name a baseline");
  check_combination(measurement, baseline);
  return fit_effects(measurement, baseline, {});
}

/// The largest force of the model along the logs. Where friction is nearly all of the force, that of the log,
/// with its noise subtracted, would leave nothing for a plan whose force is computed by the model.
double largest_force_N(const FittedModel& base) {
  constexpr double kRipple = 1.001;  // of the filter (zero_phase.cpp), with a margin
  return kRipple * base.linearisation->force_N().cwiseAbs().maxCoeff();
}

/// What is known from the logs: the effects from the excerpt that is searched, baseline and limits from all
/// samples.
void know_by_logs(KnownAxis& known, const PlanRequest& request, const std::vector<std::string>& ids,
                  const Model& model, Progress& progress) {
  SingleProcess alone;
  LogSearch logs({&alone, request.logs, {}, request.in_memory}, progress);
  Knowledge& knowledge = known.knowledge;
  do {
    const Measurement& measurement = logs.measurement();
    progress.show("fit the baseline");
    known.base = base_of(request, ids, model, measurement);
    knowledge.encoder_resolution_m = measurement.encoder_resolution_m();
    knowledge.force_noise_N = measurement.force_noise_N();
    progress.show("try the effects");
    Terms effects;
    for (const std::string& id : ids) {
      effects.push_back(try_effect(measurement, known.base, *find_effect(id), {}).term);
    }
    knowledge.scatter = scatter_of(measurement, known.base, effects);
    knowledge.effects = averaged_over_logs(measurement, std::move(effects));
    logs.fit_to_whole({&known.base}, 0.0);
    known.reached = logs.reached();
    known.measured_force_N = known.reached.force_N;
    known.model_force_N = largest_force_N(known.base);
    known.reached.force_N = std::max(known.measured_force_N, known.model_force_N);
    // The payload of the next motion is assumed to be the mean of the logs'.
    knowledge.model = averaged_over_logs(measurement, known.base.terms);
  } while (logs.extend());
  known.measurement = logs.release();
}

}  // namespace

KnownAxis known_axis(const PlanRequest& request, const std::vector<std::string>& ids, Progress& progress) {
  KnownAxis known;
  Model model;
  if (!request.model.empty()) model = read_model(request.model, request.model_content);
  Knowledge& knowledge = known.knowledge;
  knowledge.rate_Hz = request.rate_Hz;
  if (request.logs.empty()) {
    knowledge.model = request.model.empty() ? assumed_model() : model.terms;
    std::erase_if(knowledge.model, [&](const Term& term) {
      return std::find(ids.begin(), ids.end(), term.id()) != ids.end();
    });
    knowledge.encoder_resolution_m = kAssumedEncoder_m;
    knowledge.force_noise_N =
        request.model.empty() ? kAssumedNoise * kAssumedFriction_N : model.source.noise_floor_N;
    for (const std::string& id : ids) knowledge.effects.push_back(unknown_term(*find_effect(id)));
    return known;
  }
  know_by_logs(known, request, ids, model, progress);
  return known;
}

std::vector<ExpectedEvidence> KnownAxis::evidence_in_hand(const Terms& effects) const {
  if (!measurement) return {};
  return expected_evidence(*measurement, base, effects, knowledge.scatter);
}

std::string assumed_text() {
  return fmt::format("{} kg, {} N of friction, noise {} % of it", kAssumedMass_kg, kAssumedFriction_N,
                     100.0 * kAssumedNoise);
}

}  // namespace slipstack::workbench
