// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/results/diagnosis_result.h"

#include <fmt/format.h>

#include <utility>

#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/report/fit_quality.h"
#include "workbench/report/json_values.h"
#include "workbench/report/measurement_notes.h"
#include "workbench/report/parameters.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

json errors_json(const FittedModel& fitted) {
  return {{"train_rmse_N", number_json(fitted.train_rmse_N)},
          {"holdout_rmse_N", number_json(fitted.holdout_rmse_N)},
          {"forward_rmse_N", number_json(fitted.forward_rmse_N)},
          {"holdout_interval_N", interval_json(fitted)},
          {"relative_error", number_json(fitted.relative_error)}};
}

struct CandidateText {
  std::string title;
  std::string cause;
  std::string confirm;
};

/// Of a force that repeats after exactly one turn the general text of a ripple would name the motor first.
CandidateText text_of(const Term& term) {
  const auto pitch_m = term.shape(ShapeKind::pitch);
  if (pitch_m && is_one_turn(*pitch_m) && term.effect->acts_as(Acts::force)) {
    return {"Force ripple of one turn (gravity of a link)",
            "gravity of a link; an eccentric or unbalanced part; cogging once a turn",
            "creep over the whole range both ways: gravity vanishes with the axis vertical, and where the "
            "link hangs"};
  }
  const EffectText& text = term.effect->text;
  return {text.title, text_of_axis(text.cause), text_of_axis(text.confirm)};
}

json candidates_json(const Diagnosis& diagnosis) {
  json list = json::array();
  for (const Candidate& candidate : diagnosis.candidates) {
    const CandidateText text = text_of(candidate.term);
    json entry{{"effect", candidate.term.id()},
               {"title", text.title},
               {"holdout_rmse_N", number_json(candidate.holdout_rmse_N)},
               {"error_reduction", number_json(candidate.error_reduction)},
               {"error_reduction_se", number_json(candidate.error_reduction_se)},
               {"criterion_difference", number_json(candidate.criterion_difference)},
               {"confounded_with", candidate.confounded_with},
               {"evidence", candidate.evidence},
               {"refusal", name_of(candidate.refusal)},
               {"cause", text.cause},
               {"confirm_with", text.confirm}};
    if (candidate.term.effect->is_user_defined()) entry["definition"] = candidate.term.effect->definition;
    list.push_back(std::move(entry));
  }
  return list;
}

json steps_json(const Diagnosis& diagnosis) {
  json list = json::array();
  for (const Step& step : diagnosis.steps) {
    list.push_back({{"effect", step.effect},
                    {"holdout_rmse_N", number_json(step.holdout_rmse_N)},
                    {"forward_rmse_N", number_json(step.forward_rmse_N)}});
    if (step.evidence.empty()) continue;
    list.back()["evidence"] = step.evidence;
    list.back()["criterion_difference"] = number_json(step.criterion_difference);
  }
  return list;
}

/// What this log cannot show, cannot tell apart, and the experiment that would.
void add_limits(json& result, const DiagnosisRequest& request, const Diagnosis& diagnosis,
                const std::optional<NextExperiment>& next) {
  json cannot_show = json::array();
  for (const Visibility& one : diagnosis.cannot_show) {
    cannot_show.push_back({{"effect", one.effect},
                           {"least_visible_N", number_json(one.least_N)},
                           {"orthogonal_share", one.share}});
  }
  result["cannot_show"] = cannot_show;
  json cannot_separate = json::array();
  for (const Separation& pair : diagnosis.cannot_separate) {
    cannot_separate.push_back(
        {{"effect", pair.effect}, {"other", pair.other}, {"angle_deg", number_json(pair.angle_deg)}});
  }
  result["cannot_separate"] = cannot_separate;
  result["next_experiment"] = nullptr;
  if (!next) return;
  result["next_experiment"] = {{"for", next->effects},
                               {"why", reason_text(*next, [](const std::string& id) { return id; })},
                               {"command", printable(plan_command(*next, request.basis))}};
}

}  // namespace

DiagnosisResult diagnosis_result(const DiagnosisRequest& request, const Measurement& measurement,
                                 const Diagnosis& diagnosis) {
  const bool missing = diagnosis.verdict == Verdict::missing_effect;
  DiagnosisResult result{
      {},
      with_standard_errors(measurement, missing ? diagnosis.explained : diagnosis.baseline).terms,
      log_results(measurement, diagnosis.explained),
      {},
      diagnosis.input_warnings};
  // A motion is no remedy for an input in wrong units or of the wrong sign.
  if (result.warnings.empty()) result.next = next_experiment(diagnosis);
  result.json = {{"log", request.log},
                 {"samples", measurement.whole_sample_count()},
                 {"searched_samples", measurement.sample_count()},
                 {"noise", noise_json(measurement)},
                 {"repaired", repairs_json(measurement)},
                 {"input_warnings", warnings_json(result.warnings)},
                 {"noise_floor_N", number_json(diagnosis.noise_floor_N)},
                 {"discrepancy_N", number_json(discrepancy_N(diagnosis.explained, diagnosis.noise_floor_N))},
                 {"bandwidth_Hz", number_json(measurement.bandwidth_Hz())},
                 {"baseline_effects", ids_of(diagnosis.baseline.terms)},
                 {"baseline", errors_json(diagnosis.baseline)},
                 {"verdict", name_of(diagnosis.verdict)},
                 {"candidates", candidates_json(diagnosis)},
                 {"steps", steps_json(diagnosis)},
                 {"parameters", parameters_json(result.fitted)},
                 {"converged", diagnosis.explained.converged},
                 {"unexplained", nullptr}};
  if (!result.logs.empty()) result.json["logs"] = logs_json(result.logs);
  if (missing) {
    result.json["best"] = errors_json(diagnosis.best);
    result.json["best"]["effects"] = ids_of(diagnosis.best.terms);
  }
  if (diagnosis.unexplained) {
    result.json["unexplained"] = {{"coordinate", name_of(diagnosis.unexplained->coordinate)},
                                  {"description", diagnosis.unexplained->description}};
  }
  add_limits(result.json, request, diagnosis, result.next);
  return result;
}

json published_json(const DiagnosisRequest& request, const DiagnosisResult& result) {
  json published = result.json;
  if (!request.stepwise) published.erase("steps");
  return published;
}

}  // namespace slipstack::workbench
