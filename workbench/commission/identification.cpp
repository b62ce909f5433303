// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/identification.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

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

  nlohmann::json models = nlohmann::json::array();
  std::vector<std::string> added = default_baseline();
  const auto add = [&](const std::string& effect, const Terms& terms) {
    const std::string file = fmt::format("{}_{}.toml", name, models.size() + 1);
    folder.write(file, model_file(search.measurement(), fmt::format("{} logs", logs.size()), terms, added));
    models.push_back({{"added", title_of_effect(added.back())}, {"effect", effect}, {"file", file}});
  };
  add("", diagnosis.baseline.terms);
  for (const Step& step : diagnosis.steps) {
    if (find_effect(step.effect) == nullptr) continue;  // "baseline"
    added.push_back(step.effect);
    add(step.effect, step.terms);
  }
  nlohmann::json question;
  if (const auto next = next_experiment(diagnosis))
    question = {{"effects", next->effects}, {"reason", reason_text(*next, title_of_effect)}};
  return {{"verdict", name_of(diagnosis.verdict)},
          {"unexplained", diagnosis.unexplained ? diagnosis.unexplained->description : ""},
          {"models", models},
          {"question", question}};
}

std::optional<PlannedMotion> planned_motion(const std::vector<std::string>& logs,
                                            const std::vector<std::string>& effects, const AxisLimits& room,
                                            double seconds, Progress& progress) {
  PlanRequest request;
  for (const std::string& effect : effects) request.effects += (request.effects.empty() ? "" : ",") + effect;
  request.logs = logs;
  request.seconds = seconds;
  try {
    KnownAxis known = known_axis(request, effects, progress);
    AxisLimits limits = limits_of_axis({}, known.reached, known.measurement->log().motor_constant_N_per_A);
    limits.low_m = std::max(limits.low_m, room.low_m);
    limits.high_m = std::min(limits.high_m, room.high_m);
    const Plan plan = plan_experiment(known.knowledge, {limits, seconds, {}});
    known.so_far = expected_evidence(*known.measurement, known.base, plan.effects);
    const auto least = least_evidence(known.so_far, plan.expected);
    if (least && least->plan < least->log) return std::nullopt;
    return PlannedMotion{plan.motion, plan.peak_force_N};
  } catch (const std::invalid_argument&) {  // no segment fits the room
    return std::nullopt;
  } catch (const UsageError&) {  // the logs show no motion above the noise
    return std::nullopt;
  }
}

}  // namespace slipstack::workbench
