// SPDX-License-Identifier: Apache-2.0
// The parameters of a model, a block for each effect.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "workbench/base/axis_units.h"
#include "workbench/report/html/format.h"
#include "workbench/report/html/json_access.h"
#include "workbench/report/html/sections.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Value and standard error in one unit, the value rounded to two digits of its error.
struct ValueText {
  std::string value;
  std::string error;
  std::string unit;
  bool weak = false;  ///< within two standard errors of zero
};

/// Parameters of one effect with the same SI unit are shown in the same display unit, so that they can be
/// compared.
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
    // No more decimals than a double holds for this value.
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
    // For a shape, such as a position, a value near zero has no special meaning.
    const char* weak = note == "shape" ? "not determined by this log" : "≈\u00a00 within its error";
    out += "<tr><td class=\"pname\">" + escape_html(parameter_name(parameter)) + "</td><td class=\"num\">" +
           text.value + "</td><td class=\"num pm\">" + text.error + "</td><td class=\"unit\">" +
           escape_html(text.unit) + "</td><td class=\"note\">" +
           (text.weak ? "<span class=\"weak\">" + std::string(weak) + "</span> " : "") + prose_html(note) +
           "</td></tr>";
  }
  return out;
}

/// Of a hysteresis first its level, which the log determines better than any of its elements.
json with_levels(const json& effect) {
  json rows = json::array();
  for (const json& level : array_at(effect, "levels")) {
    json row{{"name", "level of all elements"},
             {"value", level["level_N"]},
             {"standard_error", level["standard_error_N"]},
             {"unit", axis_unit("N")},
             {"note", ""}};
    if (level.contains("log")) row["log"] = level["log"];
    rows.push_back(std::move(row));
  }
  for (const json& parameter : array_at(effect, "parameters")) rows.push_back(parameter);
  return rows;
}

std::string effect_block(const json& data, const json& effect) {
  const json parameters = with_levels(effect);
  const std::string id = text_at(effect, "effect");
  const std::string formula = text_at(effect, "formula");
  // Long lists (slip elements, harmonics) are set in two columns.
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
