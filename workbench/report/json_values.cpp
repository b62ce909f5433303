// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/json_values.h"

#include <cmath>
#include <utility>

#include "workbench/base/axis_units.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {

using nlohmann::json;

json number_json(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

double number_of(const json& value) {
  return value.is_number() ? value.get<double>() : std::nan("");
}

namespace {

/// The same with the names that the axis has for the quantities. The preload of a bearing is a force on any
/// axis.
json in_units_of_axis(const json& value) {
  if (value.is_array()) {
    json list = json::array();
    for (const json& item : value) list.push_back(in_units_of_axis(item));
    return list;
  }
  if (!value.is_object()) return value;
  json object = json::object();
  for (const auto& [key, item] : value.items()) {
    object[key == "normal_force_N" ? key : axis_key(key)] = in_units_of_axis(item);
  }
  return object;
}

}  // namespace

std::string own_json_text(const json& value) {
  return value.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string json_text(const json& value) {
  if (!axis_is_rotary()) return own_json_text(value);
  json published = in_units_of_axis(value);
  published["axis"] = "rotary";
  return own_json_text(published);
}

std::string published_text(json value, const std::string& schema) {
  value["schema"] = "urn:slipstack:" + schema;
  return json_text(value);
}

json report_base(const std::string& command_line, const std::string& log, const std::string& command) {
  return {{"title", "slipstack " + command}, {"command", printable(command_line)}, {"log", printable(log)}};
}

json table_json(const char* title, const std::vector<std::pair<std::string, bool>>& columns, json rows) {
  json heads = json::array();
  for (const auto& [heading, number] : columns) {
    heads.push_back({{"heading", heading}, {"unit", ""}, {"number", number}});
  }
  return {{"title", title}, {"columns", std::move(heads)}, {"rows", std::move(rows)}};
}

}  // namespace slipstack::workbench
