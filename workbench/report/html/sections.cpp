// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/html/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/report/html/chart_data.h"
#include "workbench/report/html/format.h"
#include "workbench/report/html/json_access.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

std::string entry(const std::string& term, const std::string& value_html) {
  return "<div><dt>" + escape_html(term) + "</dt><dd>" + value_html + "</dd></div>";
}

/// The name of a header key of the log, and its SI unit; on a rotary axis `rotary_name`.
struct HeaderField {
  const char* key;
  const char* name;
  const char* rotary_name;
  const char* si_unit;
  int digits;
};
constexpr std::array<HeaderField, 5> kHeaderFields = {{
    {"mass_kg", "Moving mass", "Moment of inertia", "kg", 4},
    {"magnet_pitch_m", "Magnet pitch", "Magnet pitch", "m", 4},
    {"encoder_resolution_m", "Encoder step", "Encoder step", "m", 3},
    {"motor_constant_N_per_A", "Motor constant", "Motor constant", "N/A", 4},
    {"normal_force_N", "Normal force", "Normal force", "N", 4},
}};

/// A key figure: a number in large type, and its line style in the charts.
struct KeyFigure {
  const char* key;
  const char* interval;  ///< key of its 95 % interval; "" for none
  std::string name;
  const char* role;
};

/// "95 %: 1.50 to 1.61", in the unit of the figure above it.
std::string interval_html(const json& figures, const char* key, const Column& column) {
  const json& interval = array_at(figures, key);
  if (interval.size() != 2 || !interval[0].is_number() || !interval[1].is_number()) return "";
  return "<span class=\"range\">95\u00a0%: " + column.text(interval[0].get<double>()) + " to " +
         column.text(interval[1].get<double>()) + "\u00a0" + column.unit.label + "</span>";
}

std::string key_figures_html(const json& data) {
  const json& figures = member(data, "figures");
  const bool has_after = number_at(figures, "after_rmse_N").has_value();
  const std::vector<KeyFigure> wanted = {
      {"holdout_rmse_N", "holdout_interval_N", has_after ? "Held-out error before" : "Held-out error",
       "before"},
      {"after_rmse_N", "after_interval_N", "Held-out error " + after_label(data), "after"},
      {"noise_floor_N", "", "Noise floor", "floor"},
  };
  std::vector<double> values_N;
  values_N.reserve(wanted.size());
  for (const KeyFigure& figure : wanted) values_N.push_back(number_at(figures, figure.key).value_or(0.0));
  const Column column = aligned_column("N", values_N, 2);
  std::string out;
  for (const KeyFigure& figure : wanted) {
    const auto value = number_at(figures, figure.key);
    if (!value) continue;
    out += "<div class=\"key " + std::string(figure.role) + "\"><dt>" + escape_html(figure.name) +
           interval_html(figures, figure.interval, column) + "</dt><dd>" + column.text(*value) +
           "<small>\u00a0" + column.unit.label + "</small></dd></div>";
  }
  if (const auto relative = number_at(figures, "relative_error")) {
    const auto after = number_at(figures, "after_relative_error");
    out += "<div class=\"key plain\"><dt>Relative " + std::string(force_word()) + " error" +
           std::string(after ? ", before and after" : "") + "</dt><dd>" + significant(*relative * 100.0, 3) +
           (after ? " \u2192 " + significant(*after * 100.0, 3) : "") + "<small>\u00a0%</small></dd></div>";
  }
  return out.empty() ? out : "<dl class=\"keys\">" + out + "</dl>";
}

std::string reason_cell(const char* name, const std::string& text) {
  if (text.empty()) return "";
  return "<div><dt>" + std::string(name) + "</dt><dd>" + prose_html(text) + "</dd></div>";
}

/// A command to be copied: lines break between words only.
std::string command_html(const std::string& command) {
  std::string out = "<code class=\"command\">";
  std::size_t at = 0;
  while (at < command.size()) {
    const std::size_t end = std::min(command.find(' ', at), command.size());
    out += "<span>" + escape_html(command.substr(at, end - at)) + "</span>";
    if (end < command.size()) out += ' ';
    at = end + 1;
  }
  return out + "</code>";
}

std::string confounders_text(const json& data, const json& candidate) {
  std::string names;
  for (const json& id : array_at(candidate, "confounded_with")) {
    if (!id.is_string()) continue;
    names += (names.empty() ? "" : ", ") + in_sentence(effect_title(data, text_of(id)));
  }
  return names;
}

}  // namespace

std::string percent(double share) {
  return fixed(share * 100.0, 1) + "\u00a0%";
}

std::string criterion_text(const json& data) {
  const auto difference = number_at(data, "criterion_difference");
  if (!difference || *difference == 0.0) return "";  // of an effect that was not fitted in full
  return (*difference > 0.0 ? "+" : "") + fixed(*difference, 1);
}

std::string criterion_note_html(const json& data) {
  const std::string note = text_at(data, "criterion_note");
  return note.empty() ? "" : "<p class=\"legend\">" + escape_html(note) + "</p>";
}

std::string effect_title(const json& data, const std::string& id) {
  for (const char* list : {"candidates", "parameters"}) {
    for (const json& item : array_at(data, list)) {
      if (text_at(item, "effect") != id) continue;
      std::string title = text_at(item, "title");
      if (!title.empty()) return title;
    }
  }
  std::string words = id;
  std::ranges::replace(words, '_', ' ');
  if (!words.empty() && words[0] >= 'a' && words[0] <= 'z')
    words[0] = static_cast<char>(words[0] - 'a' + 'A');
  return words;
}

std::string in_sentence(std::string title) {
  const auto is_upper = [](char c) { return c >= 'A' && c <= 'Z'; };
  if (title.size() > 1 && is_upper(title[0]) && !is_upper(title[1]))
    title[0] = static_cast<char>(title[0] - 'A' + 'a');
  return title;
}

std::string masthead_html(const json& data) {
  std::string strip;
  if (const std::string log = text_at(data, "log"); !log.empty()) strip += entry("Log", escape_html(log));
  if (const std::string setup = text_at(data, "setup"); !setup.empty()) {
    strip += entry("Set-up", escape_html(setup));
  }
  if (const auto samples = number_at(data, "samples")) strip += entry("Samples", fixed(*samples, 0));
  if (const auto duration = number_at(data, "duration_s")) {
    strip += entry("Duration", with_unit(*duration, "s", 4));
  }
  if (const auto rate = number_at(data, "sample_rate_Hz")) {
    strip += entry("Sample rate", with_unit(*rate, "Hz", 4));
  }
  for (const HeaderField& field : kHeaderFields) {
    if (const auto value = number_at(member(data, "header"), field.key)) {
      strip += entry(axis_is_rotary() ? field.rotary_name : field.name,
                     with_unit(*value, field.si_unit, field.digits));
    }
  }
  const std::string title = text_at(data, "title");
  return "<header class=\"masthead\"><p class=\"mark\">slipstack</p><p class=\"doc-title\">" +
         escape_html(title.empty() ? "Report" : title) + "</p>" +
         (strip.empty() ? "" : "<dl class=\"strip\">" + strip + "</dl>") + "</header>\n";
}

std::string verdict_html(const json& data, FigureNumbers& figures) {
  const json& verdict = member(data, "verdict");
  const std::string kind = text_at(verdict, "kind");
  std::string headline = text_at(verdict, "headline");
  if (headline.empty()) headline = text_at(data, "title");
  if (headline.empty()) headline = "Report";
  // What is found in large type, the figures of it in small.
  const std::size_t end = std::min(headline.find(". "), headline.size() - 1) + 1;
  std::string said = "<h1>" + prose_html(headline.substr(0, end));
  if (end < headline.size())
    said += " <span class=\"figures\">" + prose_html(headline.substr(end + 1)) + "</span>";
  said += "</h1>";
  if (const std::string detail = text_at(verdict, "detail"); !detail.empty()) {
    said += "<p class=\"detail\">" + prose_html(detail) + "</p>";
  }
  said += key_figures_html(data);
  const std::string waterfall = waterfall_html(data, figures);
  return "<section class=\"verdict" + std::string(waterfall.empty() ? " alone" : "") + "\" data-kind=\"" +
         escape_html(kind) + "\"><div class=\"said\">" + said + "</div>" + waterfall + "</section>\n";
}

std::string reasons_html(const json& data) {
  std::string cells;
  const json& candidates = array_at(data, "candidates");
  const std::string kind = text_at(member(data, "verdict"), "kind");
  if ((kind == "missing_effect" || kind == "added") && !candidates.empty()) {
    const json& best = candidates.front();
    // Of several effects, the values beside the others, as the headline has them.
    const json& steps = array_at(data, "steps");
    const bool several = steps.size() > 2 && !text_at(steps[1], "evidence").empty();
    cells += reason_cell("Evidence", text_at(several ? steps[1] : best, "evidence"));
    cells += reason_cell("Usual cause", text_at(best, "cause"));
    cells += reason_cell("Experiment that confirms it", text_at(best, "confirm_with"));
    cells += reason_cell("This log cannot tell it from", confounders_text(data, best));
  }
  const json& unexplained = member(data, "unexplained");
  if (const std::string left = text_at(unexplained, "description"); !left.empty()) {
    const std::string where = text_at(unexplained, "coordinate");
    cells += reason_cell("Left unexplained", where.empty() ? left : "Over " + where + ": " + left);
  }
  const json& next = member(data, "next_experiment");
  if (const std::string why = text_at(next, "why"); !why.empty()) {
    cells += "<div class=\"whole\"><dt>Next experiment</dt><dd>" + prose_html(why) +
             command_html(text_at(next, "command")) + "</dd></div>";
  }
  if (cells.empty()) return "";
  return "<section class=\"why\"><h2>Why</h2><dl class=\"reasons\">" + cells + "</dl></section>\n";
}

std::string charts_html(const json& data, FigureNumbers& figures) {
  const auto frame = [&](const char* kind, std::size_t index, const std::string& title) {
    return "<figure class=\"chart " + std::string(kind) + "\" data-chart=\"" + kind + "\" data-index=\"" +
           std::to_string(index) + "\"><figcaption><b>Fig.\u00a0" + std::to_string(figures.next()) + "</b> " +
           escape_html(title) + "</figcaption></figure>\n";
  };
  const auto titled = [](const json& item, const char* otherwise) {
    std::string title = text_at(item, "title");
    return title.empty() ? std::string(otherwise) : title;
  };
  std::string out;
  const json& series = member(data, "series");
  if (!array_at(series, "time_s").empty()) {
    const bool modelled = !array_at(series, "model_N").empty();
    const std::string force = axis_is_rotary() ? "Torque" : "Force";
    const std::string title = modelled
                                  ? force + " over time: measured and modelled, what is left, and the motion"
                                  : "Measured " + std::string(force_word()) + " over time, and the motion";
    out += "<section><h2>" + force + " over time</h2>" + frame("force", 0, title) + "</section>\n";
  }
  // The index counts all elements, also those that have nothing to draw.
  const auto frames = [&](const char* kind, const char* list, const char* x, const char* otherwise) {
    std::string html;
    const json& items = array_at(data, list);
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (!array_at(items[i], x).empty()) html += frame(kind, i, titled(items[i], otherwise));
    }
    return html;
  };
  const std::string loops = frames("loop", "loops", "displacement_m", "Hysteresis loops");
  if (!loops.empty())
    out += "<section><h2>Hysteresis</h2><div class=\"grid\">" + loops + "</div></section>\n";
  std::string left = frames("profile", "profiles", "x", "Residual");
  if (!array_at(member(data, "spectrum"), "frequency_Hz").empty()) {
    left += frame("spectrum", 0, "Spectrum of the residual");
  }
  if (!left.empty()) {
    out += "<section><h2>What is left, and where</h2><div class=\"grid\">" + left + "</div></section>\n";
  }
  return out;
}

std::string method_html(const json& data) {
  std::string rows;
  const auto row = [&rows](const char* name, const std::string& html) {
    if (!html.empty()) rows += "<div><dt>" + std::string(name) + "</dt><dd>" + html + "</dd></div>";
  };
  if (const std::string command = text_at(data, "command"); !command.empty()) {
    row("Command", "<code>" + escape_html(command) + "</code>");
  }
  std::string baseline;
  for (const json& id : array_at(data, "baseline_effects")) {
    if (!id.is_string()) continue;
    baseline += (baseline.empty() ? "" : ", ") + escape_html(effect_title(data, text_of(id))) + " <code>" +
                escape_html(text_of(id)) + "</code>";
  }
  row("Model before", baseline);
  const json& figures = member(data, "figures");
  if (number_at(figures, "holdout_rmse_N")) {
    row("Held-out error",
        fmt::format("Root mean square of the {} that the model misses, on contiguous blocks of the log that "
                    "the fit has not seen. The log alone decides where the blocks lie.",
                    force_word()));
  }
  if (const auto train = number_at(figures, "train_rmse_N")) {
    row("Error where it was fitted", with_unit(*train, "N", 3));
  }
  if (number_at(figures, "noise_floor_N")) {
    row("Noise floor",
        fmt::format("What {} noise and encoder quantisation leave even with a perfect model.", force_word()));
  }
  std::string notes;
  for (const json& note : array_at(data, "notes")) {
    if (note.is_string()) notes += "<li>" + prose_html(text_of(note)) + "</li>";
  }
  row("Notes", notes.empty() ? "" : "<ul>" + notes + "</ul>");
  if (rows.empty()) return "";
  return "<section class=\"method\"><h2>How it was measured</h2><dl class=\"rows\">" + rows +
         "</dl></section>\n";
}

}  // namespace slipstack::workbench
