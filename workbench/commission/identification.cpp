// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/identification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "workbench/commission/detection_limits.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/long_logs/log_search.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/plan/known_axis.h"
#include "workbench/plan/limits.h"
#include "workbench/report/fitted_model_file.h"
#include "workbench/report/model_notes.h"

namespace slipstack::workbench {
namespace {

std::string title_of_effect(const std::string& id) {
  const EffectDescription* effect = find_effect(id);
  return effect == nullptr ? id : std::string(effect->text.title);
}

std::string model_file(const Measurement& measurement, const std::string& logs, const Terms& terms,
                       const std::vector<std::string>& added) {
  const FittedModel fitted = with_standard_errors(measurement, fit_gains(measurement, terms));
  const double floor_N = measurement.noise_floor_N();
  Model model = model_of(logs, measurement, fitted, on_controller(measurement, fitted), floor_N);
  model.history = {change_of(logs, added, 0.0, fitted.holdout_rmse_N, floor_N)};
  return to_toml(model);
}

/// The band of a log is where the encoder's step does not yet hide the noise of the force (conditioning.h):
/// right for friction, which is slow. In the log of a drive, whose force is a smooth command, it ends at 20
/// to 40 Hz, and an arm often swings above. A mode is far above the encoder's noise at its own frequency, so
/// it is looked for up to where a motion is well sampled, a twentieth of the rate.
constexpr double kModesBelow = 0.05;
/// A mode is one whose mass is known to a third of itself. Else the fit can exchange it for the mass of the
/// axis, and frequency and damping say nothing.
constexpr double kModeStandardErrors = 3.0;

Terms without_mode(Terms terms) {
  return without(std::move(terms), effect_with_role(Role::resonance).text.id);
}

/// Modes above the band, beside what was found within it. Within the band one that swings above is taken for
/// one at its end, so a mode that was found is looked for again.
class ModesAboveBand {
 public:
  ModesAboveBand(LogRequest request, const Measurement& within, const Diagnosis& found, Progress& progress) {
    request.conditioning.bandwidth_Hz = kModesBelow * within.sample_rate_Hz();
    if (within.bandwidth_Hz() >= request.conditioning.bandwidth_Hz) return;
    search_.emplace(request, progress);
    DiagnoseOptions options;
    options.start = without_mode(found.explained.terms);
    options.baseline = ids_of(options.start);
    options.candidates = {effect_with_role(Role::resonance).id()};
    options.progress = [&](const std::string& stage, double fraction) { progress.show(stage, fraction); };
    diagnosis_ = search_->diagnose(options);
  }
  /// The model with the mode; nothing where there is none.
  const Step* mode() const {
    if (!diagnosis_) return nullptr;
    const auto step = std::find_if(diagnosis_->steps.begin(), diagnosis_->steps.end(),
                                   [](const Step& one) { return has_role(one.terms, Role::resonance); });
    if (step == diagnosis_->steps.end()) return nullptr;
    const FittedModel fitted = with_standard_errors(measurement(), fit_gains(measurement(), step->terms));
    const Term& mode = *find_role(fitted.terms, Role::resonance);
    const bool known = std::abs(mode.gains[0]) > kModeStandardErrors * mode.gain_standard_error(0);
    return known ? &*step : nullptr;
  }
  const Diagnosis& diagnosis() const { return *diagnosis_; }
  const Measurement& measurement() const { return search_->measurement(); }
  bool searched() const { return diagnosis_.has_value(); }

 private:
  std::optional<LogSearch> search_;
  std::optional<Diagnosis> diagnosis_;
};

}  // namespace

nlohmann::json identify(const std::vector<std::string>& logs, const std::string& name,
                        const CommissionFolder& folder, Progress& progress) {
  SingleProcess alone;
  LogRequest request{&alone, logs, {}};
  // One axis with one load: no gain is fitted for each log by itself.
  request.conditioning.per_log.clear();
  LogSearch search(request, progress);
  DiagnoseOptions options;
  options.baseline = default_baseline();
  options.progress = [&](const std::string& stage, double fraction) { progress.show(stage, fraction); };
  const Diagnosis diagnosis = search.diagnose(options);
  const ModesAboveBand above(request, search.measurement(), diagnosis, progress);

  nlohmann::json models = nlohmann::json::array();
  std::vector<std::string> added = default_baseline();
  const auto add = [&](const Measurement& measurement, const std::string& effect, const Terms& terms) {
    const std::string file = fmt::format("{}_{}.toml", name, models.size() + 1);
    folder.write(file, model_file(measurement, fmt::format("{} logs", logs.size()), terms, added));
    models.push_back({{"added", title_of_effect(added.back())}, {"effect", effect}, {"file", file}});
  };
  add(search.measurement(), "", diagnosis.baseline.terms);
  const Step* const mode = above.mode();
  for (const Step& step : diagnosis.steps) {
    const EffectDescription* const effect = find_effect(step.effect);
    if (effect == nullptr) continue;  // "baseline"
    if (mode != nullptr && effect->has_role(Role::resonance)) continue;
    added.push_back(step.effect);
    add(search.measurement(), step.effect, mode == nullptr ? step.terms : without_mode(step.terms));
  }
  if (mode != nullptr) {
    added.push_back(mode->effect);
    add(above.measurement(), mode->effect, mode->terms);
  }
  const Diagnosis& last = mode == nullptr ? diagnosis : above.diagnosis();
  nlohmann::json question;
  if (const auto next = next_experiment(diagnosis))
    question = {{"effects", next->effects}, {"reason", reason_text(*next, title_of_effect)}};
  nlohmann::json limits = nlohmann::json::array();
  const auto limit = [&](const std::string& text) {
    if (!text.empty()) limits.push_back(text);
  };
  limit(delay_limit_text(search.measurement(), diagnosis.explained));
  if (!above.searched()) {
    limit(mode_limit_text(search.measurement(), diagnosis.explained));
  } else if (mode == nullptr && !has_role(diagnosis.explained.terms, Role::resonance)) {
    limit(mode_limit_text(above.measurement(), above.diagnosis().baseline));
  }
  return {{"verdict", name_of(last.verdict)},
          {"unexplained", last.unexplained ? last.unexplained->description : ""},
          {"models", models},
          {"question", question},
          {"detection_limits", limits}};
}

std::optional<PlannedMotion> planned_motion(const std::vector<std::string>& logs,
                                            const std::vector<std::string>& effects, const AxisLimits& room,
                                            double seconds, Progress& progress) {
  PlanRequest request;
  for (const std::string& effect : effects) request.effects += (request.effects.empty() ? "" : ",") + effect;
  request.logs = logs;
  request.seconds = seconds;
  try {
    const KnownAxis known = known_axis(request, effects, progress);
    AxisLimits limits = limits_of_axis({}, known.reached, known.measurement->log().motor_constant_N_per_A);
    limits.low_m = std::max(limits.low_m, room.low_m);
    limits.high_m = std::min(limits.high_m, room.high_m);
    const Plan plan = plan_experiment(
        known.knowledge, {.limits = limits,
                          .seconds = seconds,
                          .in_hand = [&](const Terms& terms) { return known.evidence_in_hand(terms); },
                          .progress = {}});
    const auto least = least_evidence(plan.in_hand, plan.expected);
    if (least && least->plan < least->log) return std::nullopt;
    return PlannedMotion{plan.motion, plan.peak_force_N};
  } catch (const std::invalid_argument&) {  // no segment fits the room
    return std::nullopt;
  } catch (const UsageError&) {  // the logs show no motion above the noise
    return std::nullopt;
  }
}

}  // namespace slipstack::workbench
