// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/json_values.h"

#include <cmath>
#include <utility>

#include "workbench/base/text.h"

namespace slipstack::workbench {

using nlohmann::json;

json number_json(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

double number_of(const json& value) {
  return value.is_number() ? value.get<double>() : std::nan("");
}

std::string json_text(const json& value) {
  return value.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

json report_base(const std::string& command_line, const std::string& log, const std::string& command) {
  return {{"title", "slipstack " + command}, {"command", printable(command_line)}, {"log", printable(log)}};
}

json table_json(const char* title, const std::vector<std::pair<const char*, bool>>& columns, json rows) {
  json heads = json::array();
  for (const auto& [heading, number] : columns) {
    heads.push_back({{"heading", heading}, {"unit", ""}, {"number", number}});
  }
  return {{"title", title}, {"columns", std::move(heads)}, {"rows", std::move(rows)}};
}

}  // namespace slipstack::workbench
