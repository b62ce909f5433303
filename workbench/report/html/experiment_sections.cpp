// SPDX-License-Identifier: Apache-2.0
// Charts and tables of an experiment: their axes, curves and columns are named by the data itself.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "workbench/report/html/format.h"
#include "workbench/report/html/json_access.h"
#include "workbench/report/html/sections.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

bool is_number_column(const json& table, std::size_t column) {
  const json& columns = array_at(table, "columns");
  if (column >= columns.size()) return false;
  const json& number = member(columns[column], "number");
  return number.is_boolean() && number.get<bool>();
}

// A cell is a text, or a text with a shade from 0 to 1.
std::string cell_html(const json& table, std::size_t column, const json& cell, const char* element) {
  const std::optional<double> shade = number_at(cell, "shade");
  std::string out = fmt::format("<{}", element);
  if (is_number_column(table, column)) out += " class=\"num\"";
  if (shade) out += fmt::format(" style=\"--shade: {:.3f}\"", std::clamp(*shade, 0.0, 1.0));
  return out + fmt::format(">{}</{}>", prose_html(shade ? text_at(cell, "text") : text_of(cell)), element);
}

std::string table_html(const json& table) {
  std::string head;
  std::size_t c = 0;
  for (const json& column : array_at(table, "columns")) {
    const std::string unit = text_at(column, "unit");
    std::string heading = text_at(column, "heading");
    if (!unit.empty()) heading.append(" (").append(unit).append(")");
    head += cell_html(table, c++, heading, "th");
  }
  std::string body;
  for (const json& row : array_at(table, "rows")) {
    if (!row.is_array()) continue;
    body += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) body += cell_html(table, i, row[i], "td");
    body += "</tr>\n";
  }
  if (body.empty()) return "";
  return "<section class=\"values\"><h2>" + escape_html(text_at(table, "title")) + "</h2><table><thead><tr>" +
         head + "</tr></thead><tbody>\n" + body + "</tbody></table></section>\n";
}

}  // namespace

std::string experiment_charts_html(const json& data, FigureNumbers& figures) {
  std::string frames;
  const json& charts = array_at(data, "charts");
  for (std::size_t i = 0; i < charts.size(); ++i) {
    if (array_at(charts[i], "curves").empty()) continue;
    frames += "<figure class=\"chart curves\" data-chart=\"curves\" data-index=\"" + std::to_string(i) +
              "\"><figcaption><b>Fig.\u00a0" + std::to_string(figures.next()) + "</b> " +
              escape_html(text_at(charts[i], "title")) + "</figcaption></figure>\n";
  }
  if (frames.empty()) return "";
  return "<section><h2>Pictures</h2><div class=\"grid\">" + frames + "</div></section>\n";
}

std::string experiment_tables_html(const json& data) {
  std::string out;
  for (const json& table : array_at(data, "tables")) out += table_html(table);
  return out;
}

}  // namespace slipstack::workbench
