// SPDX-License-Identifier: Apache-2.0
// The error as it falls with each step, as a bar chart beside the verdict.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "workbench/base/axis_words.h"
#include "workbench/report/html/format.h"
#include "workbench/report/html/json_access.h"
#include "workbench/report/html/sections.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

struct Step {
  std::string name;
  double rmse_N;
  std::string criterion = {};  ///< its change against the step before; "" of the baseline
};

std::vector<Step> waterfall_steps(const json& data) {
  std::vector<Step> steps;
  for (const json& step : array_at(data, "steps")) {
    const auto rmse = number_at(step, "holdout_rmse_N");
    if (!rmse) continue;
    const std::string id = text_at(step, "effect");
    steps.push_back(
        {id == "baseline" ? "Baseline" : "+ " + effect_title(data, id), *rmse, criterion_text(step)});
  }
  if (steps.size() >= 2) return steps;
  // Without steps, the errors before and after are shown.
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
         "<text class=\"title\" x=\"50%\" y=\"30\">Held-out " + force_word() + " error (" + unit.label +
         ")</text></svg><span class=\"value\"></span><span class=\"value\"></span>";
}

/// The heading of the column of the criterion, where a step has one.
std::string waterfall_head(const std::vector<Step>& steps) {
  const bool has_criterion =
      std::ranges::any_of(steps, [](const Step& step) { return !step.criterion.empty(); });
  return has_criterion ? "<span class=\"head\">Criterion</span>" : "";
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
  std::string rows = waterfall_head(steps);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double previous = i == 0 ? steps[0].rmse_N : steps[i - 1].rmse_N;
    const bool better = steps[i].rmse_N <= previous;
    rows += "<span class=\"name\">" + escape_html(steps[i].name) +
            "</span><svg height=\"22\" aria-hidden=\"true\">" +
            bar(i == 0 ? "before" : "after", 0.0, std::min(steps[i].rmse_N, previous), full) +
            (i == 0 ? "" : bar(better ? "removed" : "grown", steps[i].rmse_N, previous, full)) + floor_line +
            "</svg><span class=\"value\">" + column.text(steps[i].rmse_N) + "\u00a0" + column.unit.label +
            "</span><span class=\"value\">" + steps[i].criterion + "</span>";
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

}  // namespace slipstack::workbench
