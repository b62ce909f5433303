// SPDX-License-Identifier: Apache-2.0
// The result of a diagnosis on a terminal.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/diagnose/detectability/ties.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/report/criterion_note.h"
#include "workbench/report/fit_quality.h"
#include "workbench/report/json_values.h"
#include "workbench/report/measurement_notes.h"
#include "workbench/report/parameters.h"
#include "workbench/report/results/diagnosis_result.h"
#include "workbench/report/texts.h"
#include "workbench/report/verdict_sentence.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// The table leaves out candidates below kLeastShownReduction, and all beyond ten: they say nothing that the
/// reader could act on. The JSON and the page have all of them.
constexpr std::size_t kMostLines = 10;

std::string error_text(const json& of) {
  return newtons(number_of(of["holdout_rmse_N"]));
}

/// Each effect alone, the lowest error first. What explains the log together is step_table().
std::string candidate_table(json candidates) {
  std::stable_sort(candidates.begin(), candidates.end(), [](const json& a, const json& b) {
    return number_of(a["holdout_rmse_N"]) < number_of(b["holdout_rmse_N"]);
  });
  std::string text =
      fmt::format("\n{:<32} {:>14} {:>9} {:>9} {:>10}  {}\n", "one effect added, each alone",
                  "held-out error", "reduction", "std. err.", "criterion", "cannot be told from");
  std::size_t lines = 0;
  for (const json& candidate : candidates) {
    const double reduction = number_of(candidate["error_reduction"]);
    if (reduction < kLeastShownReduction || lines == kMostLines) continue;
    ++lines;
    const auto others = candidate["confounded_with"].get<std::vector<std::string>>();
    text += fmt::format(
        "{:<32} {:>14} {:>7.1f} % {:>7.1f} % {:>+10.1f}{}{}\n", candidate["effect"].get<std::string>(),
        error_text(candidate), 100.0 * reduction, 100.0 * number_of(candidate["error_reduction_se"]),
        number_of(candidate["criterion_difference"]), others.empty() ? "" : "  ", fmt::join(others, ", "));
  }
  if (lines == 0) {
    return fmt::format("\nnone of the {} effects tried reduces the error by 0.5 %\n", candidates.size());
  }
  if (const std::size_t others = candidates.size() - lines; others > 0) {
    text += fmt::format("{} others reduce the error by less than 0.5 %\n", others);
  }
  return text + criterion_note() + "\n";
}

std::string step_table(const json& result) {
  std::string text =
      fmt::format("\n{:<32} {:>14} {:>10}\n", "chosen, one upon the other", "held-out error", "criterion");
  for (const json& step : result["steps"]) {
    text += fmt::format("{:<32} {:>14}", step["effect"].get<std::string>(), error_text(step));
    if (step.contains("criterion_difference")) {
      text += fmt::format(" {:>+10.1f}  {}", number_of(step["criterion_difference"]),
                          step["evidence"].get<std::string>());
    }
    text += "\n";
  }
  text += fmt::format("{:<32} {:>14}\n", "noise floor", newtons(number_of(result["noise_floor_N"])));
  // The square root of a difference that is rounding, where the error is the noise floor.
  constexpr double kRounding = 1e-6;
  const double left_N = number_of(result["discrepancy_N"]);
  const bool nothing = left_N <= kRounding * number_of(result["noise_floor_N"]);
  text +=
      fmt::format("{:<32} {:>14}\n", "left beyond the noise floor", nothing ? "nothing" : newtons(left_N));
  return text + "+-: two standard errors of a value beside the others (95 %)\n";
}

std::string interval_text(const json& of) {
  const json& interval = of["holdout_interval_N"];
  return newtons(number_of(interval[0])) + " to " + newtons(number_of(interval[1]));
}

/// The baseline and its values, by which a mass or a unit that is not that of the axis shows.
std::string baseline_lines(const json& result, const Terms& fitted) {
  const auto baseline = result["baseline_effects"].get<std::vector<std::string>>();
  std::string text = fmt::format("\nbaseline   {}\n", fmt::join(baseline, ", "));
  const std::string values = values_text(fitted, baseline);
  if (values.empty()) return text;
  return text + fmt::format("values     {}{}\n", values,
                            fitted.size() > baseline.size() ? "; beside all that is named" : "");
}

std::string interval_line(const json& result) {
  std::string text = fmt::format("intervals  baseline {}", interval_text(result["baseline"]));
  if (result.contains("best")) {
    text += fmt::format("; with {} {}", result["candidates"].front()["effect"].get<std::string>(),
                        interval_text(result["best"]));
  }
  return text + " (95 %, block bootstrap)\n";
}

/// What blocks from all over a log do not show: what drifts.
std::string forward_line(const json& steps) {
  const auto forward = [](const json& step) { return newtons(number_of(step["forward_rmse_N"])); };
  std::string text = fmt::format("forward    baseline {}", forward(steps.front()));
  if (steps.size() > 1) text += fmt::format("; with all that is named {}", forward(steps.back()));
  return text + "; in the last third of the log, predicted by a fit to the first two\n";
}

/// The usual cause of the first candidate, and the experiment that confirms it.
std::string advice(const json& candidate) {
  return fmt::format("\nusual cause   {}\nconfirm with  {}\n", candidate["cause"].get<std::string>(),
                     candidate["confirm_with"].get<std::string>());
}

/// What this log cannot show, what it cannot tell apart, and the next experiment.
std::string limits_text(const json& result) {
  std::string text;
  if (const json& cannot_show = result["cannot_show"]; !cannot_show.empty()) {
    std::vector<std::string> ids;
    for (const json& one : cannot_show) ids.push_back(one["effect"]);
    text += fmt::format("\nthis log cannot show   {}\n", fmt::join(ids, ", "));
  }
  for (const json& pair : result["cannot_separate"]) {
    text += fmt::format("{}this log {}\n", text.empty() ? "\n" : "",
                        tie_text(pair["effect"].get<std::string>(), pair["other"].get<std::string>(),
                                 number_of(pair["angle_deg"])));
  }
  if (const json& next = result["next_experiment"]; !next.is_null()) {
    text += fmt::format("\nnext experiment        {}:\n  {}\n", next["why"].get<std::string>(),
                        next["command"].get<std::string>());
  }
  return text;
}

}  // namespace

std::string diagnosis_text(const DiagnosisRequest& request, const Measurement& measurement,
                           const DiagnosisResult& result) {
  const json& found = result.json;
  const Headline headline = headline_of(found, [](const std::string& id) { return id; });
  std::string text = warning_lines(result.warnings) + headline.line + "\n" + headline.detail + "\n" +
                     candidate_table(found["candidates"]);
  // Where several were chosen, the table of each alone does not show what they do together.
  if (request.stepwise || found["steps"].size() > 2) text += step_table(found);
  text += log_table(result.logs);
  text += baseline_lines(found, result.fitted) + interval_line(found) + forward_line(found["steps"]) +
          convergence_line(found["converged"].get<bool>());
  text += noise_line(measurement) + excerpt_line(measurement, "effects searched") + repair_lines(measurement);
  if (found.contains("best")) text += advice(found["candidates"].front());
  return text + limits_text(found);
}

}  // namespace slipstack::workbench
