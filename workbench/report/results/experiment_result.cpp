// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/results/experiment_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "workbench/base/text.h"
#include "workbench/report/html/format.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Width on a terminal: continuation bytes of UTF-8 are not counted.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string blanks(width - std::min(width, width_of(text)), ' ');
  return right ? blanks + text : text + blanks;
}

std::string heading_of(const TableColumn& column) {
  return column.unit.empty() ? column.heading : fmt::format("{} {}", column.heading, column.unit);
}

std::string cell_text(const Cell& cell, const TableColumn& column) {
  if (const auto* word = std::get_if<std::string>(&cell)) return *word;
  const double value = std::get<double>(cell);
  if (!std::isfinite(value)) return "-";
  if (column.digits == 0) return fmt::format("{:.0f}", value * column.per_si);
  return fmt::format("{:.{}g}", value * column.per_si, column.digits);
}

std::string table_text(const ExperimentTable& table) {
  std::vector<std::vector<std::string>> cells;
  std::vector<std::size_t> widths;
  std::vector<bool> right;
  for (const TableColumn& column : table.columns) {
    widths.push_back(width_of(heading_of(column)));
    right.push_back(true);
  }
  for (const auto& row : table.rows) {
    std::vector<std::string> texts;
    for (std::size_t c = 0; c < row.size(); ++c) {
      texts.push_back(cell_text(row[c], table.columns[c]));
      widths[c] = std::max(widths[c], width_of(texts.back()));
      if (std::holds_alternative<std::string>(row[c])) right[c] = false;
    }
    cells.push_back(std::move(texts));
  }
  std::string text = fmt::format("\n{}\n", table.title);
  const auto line = [&](auto&& cell_at) {
    std::string out;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      out += c == 0 ? "  " : "   ";
      out += padded(cell_at(c), widths[c], right[c]);
    }
    text += out.substr(0, out.find_last_not_of(' ') + 1) + "\n";
  };
  line([&](std::size_t c) { return heading_of(table.columns[c]); });
  for (const auto& row : cells) line([&](std::size_t c) { return row[c]; });
  return text;
}

json number(double value) {
  return std::isfinite(value) ? json(value) : json();
}

json summary_json(const std::vector<SummaryEntry>& summary) {
  json out = json::object();
  for (const SummaryEntry& entry : summary) {
    out[entry.key] = std::visit(
        [](const auto& value) {
          using Value = std::decay_t<decltype(value)>;
          if constexpr (std::is_same_v<Value, double>) {
            return number(value);
          } else if constexpr (std::is_same_v<Value, std::vector<SummaryEntry>>) {
            return summary_json(value);
          } else {
            return json(value);
          }
        },
        entry.value);
  }
  return out;
}

json scaled_json(const std::vector<double>& values, double per_si) {
  json out = json::array();
  for (const double value : values) out.push_back(number(value * per_si));
  return out;
}

json chart_json(const ExperimentChart& chart) {
  const auto axis = [](const ChartAxis& of) {
    return json{{"name", of.name}, {"unit", of.unit}, {"log", of.log}};
  };
  json curves = json::array();
  std::size_t next = 0;
  for (const ChartCurve& curve : chart.curves) {
    json one{{"name", curve.name},
             {"role", curve.role.empty() ? palette_role(next++) : curve.role},
             {"dashed", curve.dashed},
             {"y", scaled_json(curve.y, chart.y_axis.per_si)}};
    if (!curve.x.empty()) one["x"] = scaled_json(curve.x, chart.x_axis.per_si);
    curves.push_back(std::move(one));
  }
  return {{"title", chart.title},         {"x_axis", axis(chart.x_axis)},
          {"y_axis", axis(chart.y_axis)}, {"x", scaled_json(chart.x, chart.x_axis.per_si)},
          {"orbit", chart.orbit},         {"curves", std::move(curves)}};
}

std::string html_text(const Cell& cell, const TableColumn& column) {
  if (const auto* word = std::get_if<std::string>(&cell)) return *word;
  const double value = std::get<double>(cell) * column.per_si;
  if (!std::isfinite(value)) return "–";
  return column.digits == 0 ? fixed(value, 0) : significant(value, column.digits);
}

json html_cell(const Cell& cell, const TableColumn& column) {
  const double* value = std::get_if<double>(&cell);
  if (value == nullptr || !(column.dark_at > 0.0) || !(*value > 0.0)) return html_text(cell, column);
  const double shade = std::log(*value / column.pale_at) / std::log(column.dark_at / column.pale_at);
  return {{"text", html_text(cell, column)}, {"shade", std::clamp(shade, 0.0, 1.0)}};
}

json table_json(const ExperimentTable& table) {
  json columns = json::array();
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const bool words = std::any_of(table.rows.begin(), table.rows.end(), [c](const auto& row) {
      return std::holds_alternative<std::string>(row[c]);
    });
    columns.push_back(
        {{"heading", table.columns[c].heading}, {"unit", table.columns[c].unit}, {"number", !words}});
  }
  json rows = json::array();
  for (const auto& row : table.rows) {
    json cells = json::array();
    for (std::size_t c = 0; c < row.size(); ++c) {
      cells.push_back(html_cell(row[c], table.columns[c]));
    }
    rows.push_back(std::move(cells));
  }
  return {{"title", table.title}, {"columns", std::move(columns)}, {"rows", std::move(rows)}};
}

}  // namespace

DisplayUnit length_unit(double magnitude_m) {
  const double size = std::fabs(magnitude_m);
  if (size >= 0.1) return {1.0, "m"};
  if (size >= 1e-3) return {1e3, "mm"};
  if (size >= 1e-7) return {1e6, "µm"};
  return {1e9, "nm"};
}

std::string palette_role(std::size_t index) {
  return fmt::format("curve{}", index % 8 + 1);
}

ExperimentChart motion_chart(const std::string& title, const std::vector<double>& time_s,
                             const std::vector<double>& position_m, const DisplayUnit& unit) {
  return {title,
          {"Time", "ms", 1e3, false},
          {"Position", unit.label, unit.per_si, false},
          time_s,
          {{"position", position_m, {}, "measured", false}},
          false};
}

std::string result_text(const ExperimentResult& result) {
  std::string text = fmt::format("set-up     {}\n{}\n", printable(result.setup), result.headline);
  if (!result.detail.empty()) text += result.detail + "\n";
  for (const ExperimentTable& table : result.tables) text += table_text(table);
  if (!result.notes.empty()) text += "\n";
  for (const std::string& note : result.notes) text += note + "\n";
  return text;
}

json result_json(const ExperimentResult& result) {
  json out{{"experiment", result.experiment},
           {"setup", printable(result.setup)},
           {"headline", result.headline},
           {"summary", summary_json(result.summary)}};
  for (const ExperimentTable& table : result.tables) {
    json rows = json::array();
    for (const auto& row : table.rows) {
      json entry = json::object();
      for (std::size_t c = 0; c < row.size(); ++c) {
        const auto* value = std::get_if<double>(&row[c]);
        entry[table.columns[c].key] = value != nullptr ? number(*value) : json(std::get<std::string>(row[c]));
      }
      rows.push_back(std::move(entry));
    }
    out[table.key] = std::move(rows);
  }
  return out;
}

json result_report(const ExperimentResult& result, const std::string& command_line) {
  const std::string command =
      result.command.empty() ? fmt::format("experiment {}", result.experiment) : result.command;
  json data{{"title", fmt::format("slipstack {}", command)},
            {"command", printable(command_line)},
            {"setup", printable(result.setup)},
            {"verdict", {{"kind", "experiment"}, {"headline", result.headline}, {"detail", result.detail}}},
            {"notes", result.notes}};
  for (const ExperimentChart& chart : result.charts) data["charts"].push_back(chart_json(chart));
  for (const ExperimentTable& table : result.tables) data["tables"].push_back(table_json(table));
  return data;
}

}  // namespace slipstack::workbench
