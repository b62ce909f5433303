// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

// Reading a report's data when any part may be missing, null or of another type: such a part counts as
// absent.
namespace slipstack::workbench {

/// The member `key` of an object, or a null value.
inline const nlohmann::json& member(const nlohmann::json& object, const char* key) {
  static const nlohmann::json kNull;
  if (!object.is_object()) return kNull;
  const auto found = object.find(key);
  return found == object.end() ? kNull : *found;
}

/// The string itself with stray bytes replaced, so that it is valid UTF-8; "" if it is no string.
inline std::string text_of(const nlohmann::json& value) {
  if (!value.is_string()) return "";
  return nlohmann::json::parse(value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace))
      .get<std::string>();
}

/// The text under `key`, or "".
inline std::string text_at(const nlohmann::json& object, const char* key) {
  return text_of(member(object, key));
}

/// The finite number under `key`.
inline std::optional<double> number_at(const nlohmann::json& object, const char* key) {
  const nlohmann::json& value = member(object, key);
  if (!value.is_number()) return std::nullopt;
  const double number = value.get<double>();
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

/// The array under `key`, or an empty one.
inline const nlohmann::json& array_at(const nlohmann::json& object, const char* key) {
  static const nlohmann::json kEmpty = nlohmann::json::array();
  const nlohmann::json& value = member(object, key);
  return value.is_array() ? value : kEmpty;
}

}  // namespace slipstack::workbench
