// SPDX-License-Identifier: Apache-2.0
// The candidates as a table with bars.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "workbench/report/html/format.h"
#include "workbench/report/html/json_access.h"
#include "workbench/report/html/sections.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Candidates that are shown; the others are folded.
constexpr std::size_t kRankingRows = 6;

/// One candidate's bar: zero line, share of the error it removes, ± one standard error.
std::string reduction_bar(double share, double error, double low, double high) {
  const auto at = [&](double value) {
    return fixed(100.0 * (std::clamp(value, low, high) - low) / (high - low), 2) + "%";
  };
  const double shown = std::clamp(share, low, high);
  std::string out = "<svg class=\"bar\" height=\"14\" aria-hidden=\"true\"><line class=\"zero\" x1=\"" +
                    at(0.0) + "\" x2=\"" + at(0.0) + "\" y1=\"0\" y2=\"14\"/><rect x=\"" +
                    at(std::min(0.0, shown)) + "\" y=\"2\" width=\"" +
                    fixed(100.0 * std::abs(shown) / (high - low), 2) + "%\" height=\"10\"/>";
  if (error > 0.0) {
    const std::string left = at(share - error);
    const std::string right = at(share + error);
    out += "<line class=\"se\" x1=\"" + left + "\" x2=\"" + right +
           "\" y1=\"7\" y2=\"7\"/><line class=\"se\" x1=\"" + left + "\" x2=\"" + left +
           "\" y1=\"4\" y2=\"10\"/><line class=\"se\" x1=\"" + right + "\" x2=\"" + right +
           "\" y1=\"4\" y2=\"10\"/>";
  }
  return out + "</svg>";
}

std::string candidate_texts(const json& candidate) {
  std::string out;
  for (const auto& [key, name] :
       {std::pair{"evidence", "Evidence"}, {"cause", "Usual cause"}, {"confirm_with", "Confirm with"}}) {
    const std::string text = text_at(candidate, key);
    if (!text.empty()) out += "<p><i>" + std::string(name) + "</i> " + prose_html(text) + "</p>";
  }
  return out;
}

std::string candidate_row(const json& data, const json& candidate, std::size_t rank, double low, double high,
                          const Column& column) {
  const std::string id = text_at(candidate, "effect");
  const std::string name =
      "<b>" + escape_html(effect_title(data, id)) + "</b> <code>" + escape_html(id) + "</code>";
  const std::string texts = candidate_texts(candidate);
  const auto rmse = number_at(candidate, "holdout_rmse_N");
  const auto share = number_at(candidate, "error_reduction");
  const double error = number_at(candidate, "error_reduction_se").value_or(0.0);
  std::string confounders;
  for (const json& other : array_at(candidate, "confounded_with")) {
    if (other.is_string()) {
      confounders += (confounders.empty() ? "" : ", ") + escape_html(effect_title(data, text_of(other)));
    }
  }
  std::string out = "<tr data-effect=\"" + escape_html(id) + "\"><td class=\"num\">" + std::to_string(rank) +
                    "</td><td class=\"effect\">";
  out += texts.empty() ? name : "<details><summary>" + name + "</summary>" + texts + "</details>";
  out += "</td><td class=\"num\">" + (rmse ? column.text(*rmse) : "–") + "</td><td class=\"bars\">" +
         (share ? reduction_bar(*share, error, low, high) : "") + "</td><td class=\"num\">" +
         (share ? percent(*share) : "–") + "</td><td class=\"num pm\">" +
         (error > 0.0 ? "±\u202f" + percent(error) : "") + "</td><td class=\"num\">" +
         criterion_text(candidate) + "</td><td>" + confounders + "</td></tr>";
  return out;
}

}  // namespace

std::string ranking_html(const json& data) {
  json candidates = array_at(data, "candidates");
  if (candidates.empty()) return "";
  // One column sorts the table; what was chosen together is the chart of the steps.
  std::stable_sort(candidates.begin(), candidates.end(), [](const json& a, const json& b) {
    return number_at(a, "holdout_rmse_N").value_or(0.0) < number_at(b, "holdout_rmse_N").value_or(0.0);
  });
  double low = 0.0;
  double high = 0.01;
  std::vector<double> errors_N;
  for (const json& candidate : candidates) {
    const double share = number_at(candidate, "error_reduction").value_or(0.0);
    const double error = number_at(candidate, "error_reduction_se").value_or(0.0);
    // A candidate that increases the error much must not compress the scale of the others.
    low = std::min(low, std::max(share - error, -0.15));
    high = std::max(high, std::min(share + error, 1.0));
    errors_N.push_back(number_at(candidate, "holdout_rmse_N").value_or(0.0));
  }
  const Column column = aligned_column("N", errors_N, 3);
  std::string shown;
  std::string folded;
  // A single further row is shown, since the button of a fold takes as much space.
  const std::size_t open_rows = candidates.size() <= kRankingRows + 1 ? candidates.size() : kRankingRows;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    (i < open_rows ? shown : folded) += candidate_row(data, candidates[i], i + 1, low, high, column);
  }
  std::string out =
      "<section class=\"ranking\"><h2>Every effect of the catalogue, each tried alone on this "
      "log</h2><table><thead><tr>"
      "<th class=\"num\">#</th><th>Effect</th><th class=\"num\">Held-out error (" +
      column.unit.label +
      ")</th><th class=\"bars\">Share of the error it removes</th><th class=\"num\">Removes</th>"
      "<th class=\"num pm\">±\u202f1 std. err.</th>"
      "<th class=\"num\">Criterion</th><th>Cannot be told from</th></tr></thead><tbody>" +
      shown + "</tbody>";
  if (!folded.empty()) {
    out +=
        "<tbody class=\"more\"><tr><td></td><td colspan=\"7\"><button type=\"button\" aria-expanded=\"true\">"
        "the other " +
        std::to_string(candidates.size() - open_rows) + "</button></td></tr></tbody><tbody class=\"rest\">" +
        folded + "</tbody>";
  }
  return out + "</table>" + criterion_note_html(data) + "</section>\n";
}

}  // namespace slipstack::workbench
