// SPDX-License-Identifier: Apache-2.0
// The parts of the report that are tables with pictures in them: waterfall, ranking, parameters.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "workbench/report/format.h"
#include "workbench/report/json_access.h"
#include "workbench/report/sections.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Candidates shown before the rest is folded away.
constexpr std::size_t kRankingRows = 6;

struct Step {
  std::string name;
  double rmse_N;
};

std::vector<Step> waterfall_steps(const json& data) {
  std::vector<Step> steps;
  for (const json& step : array_at(data, "steps")) {
    const auto rmse = number_at(step, "holdout_rmse_N");
    if (!rmse) continue;
    const std::string id = text_at(step, "effect");
    steps.push_back({id == "baseline" ? "Baseline" : "+ " + effect_title(data, id), *rmse});
  }
  if (steps.size() >= 2) return steps;
  // Without a stepwise search there are still two numbers to set side by side.
  const json& figures = member(data, "figures");
  const auto before = number_at(figures, "holdout_rmse_N");
  const auto after = number_at(figures, "after_rmse_N");
  const json& candidates = array_at(data, "candidates");
  if (!before || !after || candidates.empty()) return {};
  return {{"Baseline", *before}, {"+ " + effect_title(data, text_at(candidates.front(), "effect")), *after}};
}

/// A position along a bar of full length `full`, as SVG percentage.
std::string along(double value, double full) {
  return fixed(100.0 * value / full, 3) + "%";
}

std::string bar(const char* css_class, double from, double to, double full) {
  const double low = std::min(from, to);
  return "<rect class=\"" + std::string(css_class) + "\" x=\"" + along(low, full) + "\" y=\"4\" width=\"" +
         along(std::abs(to - from), full) + "\" height=\"14\"/>";
}

/// The decimal exponent and the step of at most five round ticks from 0 to `full`.
std::pair<int, double> tick_step(double full) {
  const int exponent = static_cast<int>(std::floor(std::log10(full / 5.0)));
  const double decade = std::pow(10.0, exponent);
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (full / (factor * decade) <= 5.0) return {exponent, factor * decade};
  }
  return {exponent + 1, 10.0 * decade};
}

std::string waterfall_axis(double full, const DisplayUnit& unit) {
  const double shown_full = full * unit.per_si;
  const auto [exponent, step] = tick_step(shown_full);
  std::string out;
  for (int i = 0; i * step <= shown_full * 1.0001; ++i) {
    const double value = i * step;
    const std::string x = along(value, shown_full);
    out += "<line x1=\"" + x + "\" x2=\"" + x + "\" y1=\"0\" y2=\"4\"/><text x=\"" + x + "\" y=\"15\">" +
           fixed(value, std::max(0, -exponent)) + "</text>";
  }
  return "<span class=\"name\"></span><svg class=\"axis\" height=\"34\" aria-hidden=\"true\">" + out +
         "<text class=\"title\" x=\"50%\" y=\"30\">Held-out force error (" + unit.label +
         ")</text></svg><span class=\"value\"></span>";
}

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
         (error > 0.0 ? "±\u202f" + percent(error) : "") + "</td><td>" +
         (confounders.empty() ? "" : confounders) + "</td></tr>";
  return out;
}

/// Value and standard error in one unit, the value rounded to two digits of its error.
struct ValueText {
  std::string value;
  std::string error;
  std::string unit;
  bool weak = false;  ///< within two standard errors of zero
};

/// Parameters of one effect that share a unit are shown in the same one, so that they compare at a glance.
double largest_with_unit(const json& parameters, const std::string& si_unit) {
  double largest = 0.0;
  for (const json& parameter : parameters) {
    if (text_at(parameter, "unit") != si_unit) continue;
    largest = std::max(largest, std::abs(number_at(parameter, "value").value_or(0.0)));
  }
  return largest;
}

ValueText value_text(const json& parameter, const json& neighbours) {
  const auto value = number_at(parameter, "value");
  const auto error = number_at(parameter, "standard_error");
  const std::string si_unit = text_at(parameter, "unit");
  if (!value) return {"–", "", si_unit, false};
  const double largest = largest_with_unit(neighbours, si_unit);
  const bool far_smaller = *value != 0.0 && std::abs(*value) < 1e-5 * largest;
  const DisplayUnit unit = display_unit(si_unit, far_smaller ? *value : largest);
  const double shown = *value * unit.per_si;
  ValueText out{significant(shown, 4), "", unit.label, false};
  if (error && *error > 0.0) {
    const double shown_error = *error * unit.per_si;
    const int decimals = 1 - static_cast<int>(std::floor(std::log10(shown_error)));
    const bool plain = std::abs(shown) < 1e7 && decimals <= 6;
    // More decimals than a double carries for this value would be invented.
    if (plain && decimals >= 0) out.value = fixed(shown, decimals);
    out.error = plain && decimals >= 0 ? fixed(shown_error, decimals) : significant(shown_error, 2);
    out.weak = std::abs(shown) < 2.0 * shown_error;
  }
  return out;
}

/// "cosine and sine 2 (log 1)", for people.
std::string parameter_name(const json& parameter) {
  std::string name = text_at(parameter, "name");
  std::ranges::replace(name, '_', ' ');
  const auto log = number_at(parameter, "log");
  return log ? name + " (log " + fixed(*log, 0) + ")" : name;
}

std::string parameter_rows(const json& parameters, std::size_t first, std::size_t last) {
  std::string out;
  for (std::size_t i = first; i < last; ++i) {
    const json& parameter = parameters[i];
    const ValueText text = value_text(parameter, parameters);
    const std::string note = text_at(parameter, "note");
    // A shape says where something happens: there "zero" would mean nothing.
    const char* weak = note == "shape" ? "not determined by this log" : "≈\u00a00 within its error";
    out += "<tr><td class=\"pname\">" + escape_html(parameter_name(parameter)) + "</td><td class=\"num\">" +
           text.value + "</td><td class=\"num pm\">" + (text.error.empty() ? "" : "±\u202f" + text.error) +
           "</td><td class=\"unit\">" + escape_html(text.unit) + "</td><td class=\"note\">" +
           (text.weak ? "<span class=\"weak\">" + std::string(weak) + "</span> " : "") + prose_html(note) +
           "</td></tr>";
  }
  return out;
}

std::string effect_block(const json& data, const json& effect) {
  const json& parameters = array_at(effect, "parameters");
  const std::string id = text_at(effect, "effect");
  const std::string formula = text_at(effect, "formula");
  // Long lists (slip elements, harmonics) stand in two columns across the page.
  const bool wide = parameters.size() > 10;
  const std::size_t half = wide ? (parameters.size() + 1) / 2 : parameters.size();
  std::string tables;
  for (std::size_t first = 0; first < parameters.size(); first += half) {
    tables +=
        "<table><thead><tr><th>Parameter</th><th class=\"num\">Value</th><th class=\"pm\">Std. error</th>"
        "<th>Unit</th><th></th></tr></thead><tbody>" +
        parameter_rows(parameters, first, std::min(first + half, parameters.size())) + "</tbody></table>";
  }
  return "<div class=\"block" + std::string(wide ? " wide" : "") + "\"><h3>" +
         escape_html(effect_title(data, id)) + " <code>" + escape_html(id) + "</code></h3>" +
         (formula.empty() ? "" : "<p class=\"formula\">" + escape_html(formula) + "</p>") +
         "<div class=\"halves\">" + tables + "</div></div>";
}

}  // namespace

std::string waterfall_html(const json& data, FigureNumbers& figures) {
  const std::vector<Step> steps = waterfall_steps(data);
  if (steps.empty()) return "";
  const auto floor = number_at(member(data, "figures"), "noise_floor_N");
  double full = floor.value_or(0.0);
  for (const Step& step : steps) full = std::max(full, step.rmse_N);
  if (full <= 0.0) return "";
  std::vector<double> values_N;
  values_N.reserve(steps.size());
  for (const Step& step : steps) values_N.push_back(step.rmse_N);
  const Column column = aligned_column("N", values_N, 3);
  const std::string floor_line = floor ? "<line class=\"floor\" x1=\"" + along(*floor, full) + "\" x2=\"" +
                                             along(*floor, full) + "\" y1=\"0\" y2=\"22\"/>"
                                       : "";
  std::string rows;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double previous = i == 0 ? steps[0].rmse_N : steps[i - 1].rmse_N;
    const bool better = steps[i].rmse_N <= previous;
    rows += "<span class=\"name\">" + escape_html(steps[i].name) +
            "</span><svg height=\"22\" aria-hidden=\"true\">" +
            bar(i == 0 ? "before" : "after", 0.0, std::min(steps[i].rmse_N, previous), full) +
            (i == 0 ? "" : bar(better ? "removed" : "grown", steps[i].rmse_N, previous, full)) + floor_line +
            "</svg><span class=\"value\">" + column.text(steps[i].rmse_N) + "\u00a0" + column.unit.label +
            "</span>";
  }
  rows += waterfall_axis(full, column.unit);
  return "<figure class=\"waterfall\"><figcaption><b>Fig.\u00a0" + std::to_string(figures.next()) +
         "</b> The error falls</figcaption><svg class=\"defs\" width=\"0\" height=\"0\" "
         "aria-hidden=\"true\"><defs>"
         "<pattern id=\"hatch\" width=\"5\" height=\"5\" patternUnits=\"userSpaceOnUse\" "
         "patternTransform=\"rotate(45)\"><line x1=\"0\" y1=\"0\" x2=\"0\" y2=\"5\"/></pattern></defs></svg>"
         "<div class=\"steps\">" +
         rows + "</div><p class=\"legend\"><span class=\"swatch removed\"></span>removed by the step" +
         (floor ? "<span class=\"swatch floor\"></span>noise floor " + with_unit(*floor, "N", 3) : "") +
         "</p></figure>";
}

std::string ranking_html(const json& data) {
  const json& candidates = array_at(data, "candidates");
  if (candidates.empty()) return "";
  double low = 0.0;
  double high = 0.01;
  std::vector<double> errors_N;
  for (const json& candidate : candidates) {
    const double share = number_at(candidate, "error_reduction").value_or(0.0);
    const double error = number_at(candidate, "error_reduction_se").value_or(0.0);
    // A candidate that makes things much worse must not squeeze the others into a sliver.
    low = std::min(low, std::max(share - error, -0.15));
    high = std::max(high, std::min(share + error, 1.0));
    errors_N.push_back(number_at(candidate, "holdout_rmse_N").value_or(0.0));
  }
  const Column column = aligned_column("N", errors_N, 3);
  const bool together = !std::ranges::is_sorted(errors_N);
  std::string shown;
  std::string folded;
  // One more row costs less than a fold that hides a single one.
  const std::size_t open_rows = candidates.size() <= kRankingRows + 1 ? candidates.size() : kRankingRows;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    (i < open_rows ? shown : folded) += candidate_row(data, candidates[i], i + 1, low, high, column);
  }
  std::string out =
      "<section class=\"ranking\"><h2>Every effect of the catalogue, tried on this log</h2><table><thead><tr>"
      "<th class=\"num\">#</th><th>Effect</th><th class=\"num\">Held-out error (" +
      column.unit.label +
      ")</th><th colspan=\"3\">Share of the error it removes, ± 1 standard error</th>"
      "<th>Not told apart from</th></tr></thead><tbody>" +
      shown + "</tbody>";
  if (!folded.empty()) {
    out +=
        "<tbody class=\"more\"><tr><td></td><td colspan=\"6\"><button type=\"button\" aria-expanded=\"true\">"
        "the other " +
        std::to_string(candidates.size() - open_rows) + "</button></td></tr></tbody><tbody class=\"rest\">" +
        folded + "</tbody>";
  }
  out += "</table>";
  if (together) {
    out +=
        "<p class=\"legend\">First the effects that explain the log together, then the others; each with the "
        "error it leaves alone.</p>";
  }
  return out + "</section>\n";
}

std::string parameters_html(const json& data) {
  std::string blocks;
  for (const json& effect : array_at(data, "parameters")) {
    if (!array_at(effect, "parameters").empty()) blocks += effect_block(data, effect);
  }
  if (blocks.empty()) return "";
  return "<section class=\"parameters\"><h2>Parameters</h2><div class=\"blocks\">" + blocks +
         "</div></section>\n";
}

}  // namespace slipstack::workbench
