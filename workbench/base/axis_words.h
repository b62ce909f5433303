// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "workbench/base/axis_units.h"

namespace slipstack::workbench {

/// What moves the axis, in sentences: "force", or of a rotary axis "torque".
inline const char* force_word() {
  return axis_is_rotary() ? "torque" : "force";
}

/// What it moves: "mass", or of a rotary axis "moment of inertia".
inline const char* mass_word() {
  return axis_is_rotary() ? "moment of inertia" : "mass";
}

/// The alternatives of a text "linear | rotary"; of one without them, that and nothing.
inline std::pair<std::string, std::string> alternatives_of(std::string_view text) {
  constexpr std::string_view kBetween = " | ";
  const std::size_t at = text.find(kBetween);
  if (at == std::string_view::npos) return {std::string(text), ""};
  return {std::string(text.substr(0, at)), std::string(text.substr(at + kBetween.size()))};
}

/// Of such a text the alternative of the axis; a text without alternatives as it is.
inline std::string text_of_axis(std::string_view text) {
  auto [linear, rotary] = alternatives_of(text);
  return axis_is_rotary() && !rotary.empty() ? rotary : linear;
}

/// Both alternatives of such a text as one, for pages that are about any axis.
inline std::string text_of_any_axis(std::string_view text) {
  const auto [linear, rotary] = alternatives_of(text);
  return rotary.empty() ? linear : linear + ". On a rotary axis: " + rotary;
}

}  // namespace slipstack::workbench
