// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/views/diagnosis_cards.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/evidence/evidence.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/model.h"
#include "workbench/report/criterion_note.h"
#include "workbench/report/html/sections.h"
#include "workbench/report/json_values.h"
#include "workbench/report/pictures.h"
#include "workbench/report/results/diagnosis_result.h"
#include "workbench/report/texts.h"
#include "workbench/report/verdict_sentence.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

void add_to_card(json& card, const Measurement& measurement, const Diagnosis& diagnosis,
                 const Candidate& candidate) {
  const EffectText& text = candidate.term.effect->text;
  card["formula"] = text.formula;
  card["look"] = text.residual;
  card["term"] = {{"shapes", candidate.term.shapes}, {"gains", candidate.term.gains}};
  card["expected"] = expected_means(measurement, expected_residual_N(diagnosis.baseline, candidate.term));
}

std::string title_of(const json& result, const std::string& id) {
  for (const json& candidate : result["candidates"]) {
    if (candidate["effect"] == id) return in_sentence(candidate["title"]);
  }
  return id;
}

}  // namespace

json tried_card(const Trial& trial, double baseline_N) {
  const EffectText& text = trial.term.effect->text;
  return {{"effect", text.id},
          {"title", text.title},
          {"formula", text.formula},
          {"evidence", trial.below_visible ? "" : text.residual},
          {"holdout_rmse_N", number_json(trial.holdout_rmse_N)},
          {"error_reduction", number_json(1.0 - trial.holdout_rmse_N / baseline_N)}};
}

json diagnosis_cards(LogSearch& logs, const std::string& model_path,
                     const std::vector<std::string>& user_effects, Progress& progress,
                     const std::function<void(json)>& tried) {
  const Model model = read_model(model_path);
  DiagnoseOptions wanted;
  wanted.user_effects = declare_effects(user_effects);
  wanted.baseline = ids_of(model.terms);
  wanted.start = model.terms;
  wanted.progress = [&progress](const std::string& stage, double fraction) {
    progress.show(stage, fraction);
  };
  wanted.tried = [&tried](const Trial& trial, double baseline_N) { tried(tried_card(trial, baseline_N)); };
  const Diagnosis diagnosis = logs.diagnose(wanted);
  const Measurement& measurement = logs.measurement();
  std::string command = "slipstack diagnose";
  for (const std::string& path : logs.paths()) command += " " + path;
  command += " --stepwise --model " + model_path;
  const DiagnosisRequest asked{command, joined(logs.paths()), {logs.paths(), model_path}, true};
  DiagnosisResult result = diagnosis_result(asked, measurement, diagnosis);
  json cards = std::move(result.json);
  for (std::size_t i = 0; i < diagnosis.candidates.size(); ++i) {
    add_to_card(cards["candidates"][i], measurement, diagnosis, diagnosis.candidates[i]);
  }
  const Headline headline = headline_of(cards, [&](const std::string& id) { return title_of(cards, id); });
  cards["headline"] = headline.line;
  cards["detail"] = headline.detail;
  cards["criterion_note"] = sentence(criterion_note());
  cards["command"] = printable(command);
  return cards;
}

std::optional<Term> term_of_card(const Measurement& measurement, const json& diagnosis,
                                 const std::string& effect) {
  for (const json& card : diagnosis.at("candidates")) {
    if (card.at("effect") != effect || !card.contains("term")) continue;
    Term term = make_term(measurement, effect_named(effect));
    const std::vector<double> shapes = card["term"]["shapes"];
    const std::vector<double> gains = card["term"]["gains"];
    if (shapes.size() != term.shapes.size()) break;
    term.shapes = shapes;
    if (gains.size() == term.gains.size()) term.gains = gains;
    return term;
  }
  return std::nullopt;
}

}  // namespace slipstack::workbench
