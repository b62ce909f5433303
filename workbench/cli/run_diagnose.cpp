// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "workbench/cli/commands.h"
#include "workbench/cli/inputs.h"
#include "workbench/cli/next_experiment.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/report/html.h"
#include "workbench/report/results.h"
#include "workbench/report/sections.h"
#include "workbench/report/text_tables.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

struct Headline {
  std::string line;
  std::string detail;
};

/// How an effect is called in a sentence: by its id, or on a page by its title.
std::string called(const std::string& id, bool by_title) {
  const EffectDescription* effect = by_title ? find_effect(id) : nullptr;
  return effect == nullptr ? id : in_sentence(effect->text.title);
}

Headline headline_of(const Diagnosis& diagnosis, bool by_title) {
  const std::string floor = newtons(diagnosis.noise_floor_N);
  const std::string before = newtons(diagnosis.baseline.holdout_rmse_N);
  if (diagnosis.verdict == Verdict::complete) {
    return {
        fmt::format("Complete: held-out error {}, noise floor {}.", before, floor),
        "No effect of the catalogue earns its parameters on data that the fit has not seen, and nothing that "
        "depends on one coordinate is left."};
  }
  if (diagnosis.verdict == Verdict::unexplained) {
    return {fmt::format("Unexplained: held-out error {}, noise floor {}.", before, floor),
            diagnosis.unexplained
                ? "No effect of the catalogue accounts for it; " + diagnosis.unexplained->description + "."
                : "No effect of the catalogue accounts for it."};
  }
  const Candidate& first = diagnosis.candidates.front();
  Headline headline{
      fmt::format("Missing: {}. Adding it lowers the held-out error from {} to {}; noise floor {}.",
                  first.term.effect->text.title, before, newtons(diagnosis.best.holdout_rmse_N), floor),
      "Why: " + first.evidence + "."};
  if (diagnosis.steps.size() > 2) {
    headline.detail += " Not alone: with ";
    for (std::size_t i = 2; i < diagnosis.steps.size(); ++i) {
      headline.detail += (i > 2 ? ", " : "") + called(diagnosis.steps[i].added, by_title);
    }
    headline.detail += fmt::format(" the error falls to {}.", newtons(diagnosis.steps.back().holdout_rmse_N));
  }
  if (diagnosis.unexplained) headline.detail += " Still open: " + diagnosis.unexplained->description + ".";
  return headline;
}

json result_of(const Options& options, const Measurement& measurement, const Diagnosis& diagnosis) {
  json result{{"log", options.log},
              {"samples", measurement.whole_sample_count()},
              {"baseline_effects", ids_of(diagnosis.baseline.terms)},
              {"noise_floor_N", number_json(diagnosis.noise_floor_N)},
              {"baseline",
               {{"train_rmse_N", number_json(diagnosis.baseline.train_rmse_N)},
                {"holdout_rmse_N", number_json(diagnosis.baseline.holdout_rmse_N)},
                {"holdout_interval_N", interval_json(diagnosis.baseline)},
                {"relative_error", number_json(diagnosis.baseline.relative_error)}}},
              {"verdict", name_of(diagnosis.verdict)},
              {"candidates", candidates_json(diagnosis)},
              {"unexplained", nullptr}};
  result["noise"] = noise_json(measurement);
  result["searched_samples"] = measurement.sample_count();
  result["repaired"] = repairs_json(measurement);
  const std::vector<LogResult> logs = log_results(measurement, diagnosis.explained);
  if (!logs.empty()) result["logs"] = logs_json(logs);
  add_limits(result, options, diagnosis);
  if (diagnosis.verdict == Verdict::missing_effect) {
    result["best"] = {{"effects", ids_of(diagnosis.best.terms)},
                      {"train_rmse_N", number_json(diagnosis.best.train_rmse_N)},
                      {"holdout_rmse_N", number_json(diagnosis.best.holdout_rmse_N)},
                      {"holdout_interval_N", interval_json(diagnosis.best)},
                      {"relative_error", number_json(diagnosis.best.relative_error)}};
  }
  if (options.stepwise) result["steps"] = steps_json(diagnosis);
  if (diagnosis.unexplained) {
    result["unexplained"] = {{"coordinate", diagnosis.unexplained->coordinate},
                             {"description", diagnosis.unexplained->description}};
  }
  return result;
}

json report_of(const Options& options, const Measurement& measurement, const Diagnosis& diagnosis,
               const json& result, const Model& model) {
  const Headline headline = headline_of(diagnosis, true);
  const bool found = diagnosis.verdict == Verdict::missing_effect;
  const FittedModel& shown = !found             ? diagnosis.baseline
                             : options.stepwise ? diagnosis.explained
                                                : diagnosis.best;
  json data = report_base(options.command_line, options.log, "diagnose");
  data["verdict"] = {
      {"kind", name_of(diagnosis.verdict)}, {"headline", headline.line}, {"detail", headline.detail}};
  data["figures"] = figures_json(diagnosis.baseline, diagnosis.noise_floor_N);
  data["figures"]["holdout_interval_N"] = interval_json(diagnosis.baseline);
  if (found) {
    data["figures"]["after_rmse_N"] = number_json(shown.holdout_rmse_N);
    data["figures"]["after_interval_N"] = interval_json(shown);
    data["figures"]["after_relative_error"] = number_json(shown.relative_error);
    const std::size_t added = options.stepwise ? diagnosis.steps.size() : 2;
    for (std::size_t i = 1; i < std::min(added, diagnosis.steps.size()); ++i) {
      data["after_effects"].push_back(diagnosis.steps[i].added);
    }
  }
  data["baseline_effects"] = result["baseline_effects"];
  data["candidates"] = result["candidates"];
  data["steps"] = steps_json(diagnosis);
  data["unexplained"] = result["unexplained"];
  data["parameters"] = parameters_json(with_standard_errors(measurement, shown).terms);
  const ForceRows before = rows_of(diagnosis.baseline);
  const ForceRows after = rows_of(shown);
  add_pictures(data, measurement, before, found ? &after : nullptr);
  if (!diagnosis.candidates.empty() && diagnosis.candidates.front().error_reduction > 0.0) {
    const Term& first = diagnosis.candidates.front().term;
    add_expected(data, measurement, "as " + called(first.id(), true) + " would leave it",
                 expected_residual_N(diagnosis.baseline, first));
  }
  add_logs(data, log_results(measurement, diagnosis.explained));
  add_limits_report(data, options, diagnosis);
  if (!options.model.empty()) add_history(data, model);
  return data;
}

std::string text_of(const Options& options, const Measurement& measurement, const Diagnosis& diagnosis) {
  const Headline headline = headline_of(diagnosis, false);
  std::string text = headline.line + "\n" + headline.detail + "\n" + candidate_table(diagnosis);
  if (options.stepwise) text += step_table(diagnosis);
  text += log_table(log_results(measurement, diagnosis.explained));
  text += fmt::format("\nintervals  baseline {}", interval_text(diagnosis.baseline));
  if (diagnosis.verdict == Verdict::missing_effect) {
    text +=
        fmt::format("; with {} {}", diagnosis.candidates.front().term.id(), interval_text(diagnosis.best));
  }
  text += " (95 %, block bootstrap)\n";
  text += noise_line(measurement) + excerpt_line(measurement, "effects searched") + repair_lines(measurement);
  if (diagnosis.verdict == Verdict::missing_effect) text += advice(diagnosis.candidates.front());
  text += limits_text(options, diagnosis);
  return text;
}

}  // namespace

void run_diagnose(const Options& options) {
  DiagnoseOptions wanted;
  wanted.own = declare_effects(options.user_effects);
  Outputs outputs;
  spare_logs(options, outputs);
  if (!options.model.empty()) outputs.protect_input(options.model);
  outputs.claim(options.report);
  outputs.claim(options.json);
  Model model;
  if (!options.model.empty()) model = read_model(options.model);
  wanted.baseline = options.model.empty()
                        ? parse_effects(options.effects.empty() ? kDefaultBaseline : options.effects)
                        : ids_of(model.terms);
  Progress progress;
  if (!options.model.empty()) wanted.start = model.terms;
  wanted.progress = [&progress](const std::string& stage, double fraction) {
    progress.show(stage, fraction);
  };
  LogSearch logs(log_request(options), progress);
  const Diagnosis diagnosis = logs.diagnose(wanted);
  const Measurement& measurement = logs.measurement();

  const json result = result_of(options, measurement, diagnosis);
  if (!options.report.empty()) {
    progress.show("write the report");
    outputs.set(options.report, render_report(report_of(options, measurement, diagnosis, result, model)));
  }
  outputs.set(options.json, json_text(result));
  progress.finish();
  outputs.commit(text_of(options, measurement, diagnosis));
}

}  // namespace slipstack::workbench
