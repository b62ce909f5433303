// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/html/chart_data.h"

#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "workbench/base/axis_units.h"
#include "workbench/base/quantity.h"
#include "workbench/report/html/json_access.h"
#include "workbench/report/html/sections.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

// Seven digits resolve a chart of 1 000 pixels that is magnified a thousand times; the time of a long record
// needs more.
constexpr int kValueDigits = 7;
constexpr int kCoordinateDigits = 10;

int digits_for(std::string_view key) {
  const bool coordinate = key == "time_s" || key == "position_m" || key == "displacement_m" || key == "x";
  return coordinate ? kCoordinateDigits : kValueDigits;
}

void append_number(std::string& out, double value, int digits) {
  if (!std::isfinite(value)) {
    out += "null";
    return;
  }
  std::array<char, 40> buffer{};
  const auto result =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, digits);
  out.append(buffer.data(), result.ptr);
}

void append_string(std::string& out, const std::string& text) {
  for (const char c : json(text).dump(-1, ' ', true, json::error_handler_t::replace)) {
    // Only `<` can end a script element or open a comment in it; > and & cannot.
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
}

void append_value(std::string& out, const json& value, int digits);

template <typename Each>
void append_list(std::string& out, char open, char close, const json& values, Each&& each) {
  out += open;
  bool first = true;
  for (auto it = values.begin(); it != values.end(); ++it) {
    if (!first) out += ',';
    first = false;
    each(it);
  }
  out += close;
}

void append_value(std::string& out, const json& value, int digits) {
  if (value.is_number()) {
    append_number(out, value.get<double>(), digits);
  } else if (value.is_string()) {
    append_string(out, value.get<std::string>());
  } else if (value.is_boolean()) {
    out += value.get<bool>() ? "true" : "false";
  } else if (value.is_array()) {
    append_list(out, '[', ']', value, [&](const auto& it) { append_value(out, *it, digits); });
  } else if (value.is_object()) {
    append_list(out, '{', '}', value, [&](const auto& it) {
      append_string(out, it.key());
      out += ':';
      append_value(out, *it, digits_for(it.key()));
    });
  } else {
    out += "null";
  }
}

}  // namespace

json rotary_units() {
  json units = json::object();
  for (const char* si_unit : {"N", "m", "m/s", "m/s²", "N/√Hz"}) {
    for (const UnitStep& step : unit_steps(si_unit)) {
      units[si_unit].push_back({step.smallest, step.unit.per_si, step.unit.label});
    }
  }
  return units;
}

std::string after_label(const json& data) {
  const std::string kind = text_at(member(data, "verdict"), "kind");
  const json& candidates = array_at(data, "candidates");
  const json& added = array_at(data, "after_effects");
  if (added.size() > 2) return "with all " + std::to_string(added.size()) + " effects added";
  if (added.size() == 2) {
    return "with " + in_sentence(effect_title(data, text_of(added[0]))) + " and " +
           in_sentence(effect_title(data, text_of(added[1]))) + " added";
  }
  if ((kind == "missing_effect" || kind == "added") && !candidates.empty()) {
    const std::string id = text_at(candidates.front(), "effect");
    if (!id.empty()) return "with " + in_sentence(effect_title(data, id)) + " added";
  }
  return "after";
}

std::string chart_data_json(const json& data) {
  // The acceleration has no chart over time; its profile is enough, and the page stays smaller.
  json series = json::object();
  for (const char* key :
       {"time_s", "position_m", "velocity_mps", "measured_N", "model_N", "residual_N", "after_N"}) {
    series[key] = array_at(member(data, "series"), key);
  }
  std::string out = "{\"series\":";
  append_value(out, series, kValueDigits);
  out += ',';
  for (const char* key : {"loops", "profiles", "spectrum", "charts"}) {
    append_string(out, key);
    out += ':';
    append_value(out, member(data, key), kValueDigits);
    out += ',';
  }
  out += "\"noise_floor_N\":";
  append_value(out, member(member(data, "figures"), "noise_floor_N"), kValueDigits);
  out += ",\"after_label\":";
  append_string(out, after_label(data));
  if (axis_is_rotary()) {
    out += ",\"units\":";
    append_value(out, rotary_units(), kCoordinateDigits);
  }
  return out + "}";
}

}  // namespace slipstack::workbench
