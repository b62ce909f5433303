// SPDX-License-Identifier: Apache-2.0
// The result of a diagnosis as the data of the report.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "workbench/base/axis_words.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/report/criterion_note.h"
#include "workbench/report/fit_quality.h"
#include "workbench/report/html/sections.h"
#include "workbench/report/json_values.h"
#include "workbench/report/measurement_notes.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/parameters.h"
#include "workbench/report/results/diagnosis_result.h"
#include "workbench/report/texts.h"
#include "workbench/report/verdict_sentence.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// The title of a candidate; its id where it has none.
std::string title_of(const json& result, const std::string& id) {
  for (const json& candidate : result["candidates"]) {
    if (candidate["effect"] == id) return candidate["title"];
  }
  return id;
}

/// The title and, in brackets, the id.
std::string heading_of(const json& result, const std::string& id) {
  return fmt::format("{} ({})", title_of(result, id), id);
}

/// Figures of the baseline, and of the model that is drawn beside it (null: none).
json figures_of(const json& result, const FittedModel* after) {
  json figures = result["baseline"];
  figures["noise_floor_N"] = result["noise_floor_N"];
  if (after == nullptr) return figures;
  figures["after_rmse_N"] = number_json(after->holdout_rmse_N);
  figures["after_interval_N"] = interval_json(*after);
  figures["after_relative_error"] = number_json(after->relative_error);
  return figures;
}

json cannot_show_table(const json& result) {
  json rows = json::array();
  for (const json& one : result["cannot_show"]) {
    const double least_N = number_of(one["least_visible_N"]);
    rows.push_back({heading_of(result, one["effect"]),
                    std::isfinite(least_N) ? newtons(least_N) : fmt::format("no {}", force_word()),
                    share(one["orthogonal_share"])});
  }
  return table_json("What this log cannot show",
                    {{"Effect", false},
                     {fmt::format("Named from a peak {} of", force_word()), true},
                     {"Share of it that the model cannot imitate", true}},
                    std::move(rows));
}

json ties_table(const json& result) {
  json rows = json::array();
  for (const json& pair : result["cannot_separate"]) {
    rows.push_back({heading_of(result, pair["effect"]), heading_of(result, pair["other"]),
                    fmt::format("{:.1f}°", number_of(pair["angle_deg"]))});
  }
  return table_json("What this log cannot tell apart",
                    {{"Effect", false},
                     {"Cannot be told from", false},
                     {fmt::format("Angle between their {}s", force_word()), true}},
                    std::move(rows));
}

void add_limits(json& page, const DiagnosisResult& result, const EffectName& name) {
  if (!result.json["cannot_show"].empty()) page["tables"].push_back(cannot_show_table(result.json));
  if (!result.json["cannot_separate"].empty()) page["tables"].push_back(ties_table(result.json));
  if (!result.next) return;
  page["next_experiment"] = {{"why", sentence(reason_text(*result.next, name))},
                             {"command", result.json["next_experiment"]["command"]}};
}

}  // namespace

json diagnosis_page(const DiagnosisRequest& request, const Measurement& measurement,
                    const Diagnosis& diagnosis, const DiagnosisResult& result, const Model* model) {
  const json& found = result.json;
  const EffectName name = [&](const std::string& id) { return in_sentence(title_of(found, id)); };
  const bool missing = diagnosis.verdict == Verdict::missing_effect;
  const bool first_only = missing && !request.stepwise;
  const FittedModel& shown = !missing     ? diagnosis.baseline
                             : first_only ? diagnosis.best
                                          : diagnosis.explained;
  const Headline headline = headline_of(found, name);
  json page = report_base(request.command_line, request.log, "diagnose");
  page["verdict"] = {{"kind", found["verdict"]},
                     {"headline", headline.line},
                     {"detail", warning_sentences(result.warnings) + headline.detail}};
  page["figures"] = figures_of(found, missing ? &shown : nullptr);
  if (missing) {
    const std::size_t drawn = std::min(request.stepwise ? diagnosis.steps.size() : 2, diagnosis.steps.size());
    for (std::size_t i = 1; i < drawn; ++i) page["after_effects"].push_back(diagnosis.steps[i].effect);
  }
  for (const char* key : {"baseline_effects", "candidates", "steps", "unexplained"}) page[key] = found[key];
  page["criterion_note"] = sentence(criterion_note());
  page["parameters"] =
      first_only ? parameters_json(with_standard_errors(measurement, shown).terms) : found["parameters"];
  add_friction_each_way(page, shown);
  const ForceRows before = rows_of(diagnosis.baseline);
  const ForceRows after = rows_of(shown);
  add_pictures(page, measurement, before, missing ? &after : nullptr);
  if (!diagnosis.candidates.empty() && diagnosis.candidates.front().error_reduction > 0.0) {
    const Term& first = diagnosis.candidates.front().term;
    add_expected(page, measurement, "as " + name(first.id()) + " would leave it",
                 expected_residual_N(diagnosis.baseline, first));
  }
  add_logs(page, result.logs);
  add_limits(page, result, name);
  if (model != nullptr) add_history(page, *model);
  return page;
}

}  // namespace slipstack::workbench
