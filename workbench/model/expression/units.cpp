// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/expression/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

constexpr std::array<std::string_view, 11> kUnits{"N", "m", "s", "kg", "A", "Hz", "rad", "K", "Pa", "J", "W"};

bool is_unit(std::string_view symbol) {
  return std::find(kUnits.begin(), kUnits.end(), symbol) != kUnits.end();
}

bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// A unit with a prefix, as in "mm": the workbench wants the one without.
std::string_view without_prefix(std::string_view symbol) {
  constexpr std::string_view kPrefixes = "numkMG";
  const bool prefixed =
      symbol.size() > 1 && kPrefixes.find(symbol[0]) != std::string_view::npos && is_unit(symbol.substr(1));
  return prefixed ? symbol.substr(1) : std::string_view();
}

}  // namespace

std::string unit_fault(std::string_view unit) {
  if (unit == "1") return {};
  std::size_t at = 0;
  bool any = false;
  while (at < unit.size()) {
    if (unit[at] == ' ' || unit[at] == '*' || (unit[at] == '/' && any)) {
      ++at;
      continue;
    }
    if (unit.substr(at, 2) == "1/" && !any) {
      any = true;
      at += 1;
      continue;
    }
    std::size_t end = at;
    while (end < unit.size() && is_letter(unit[end])) ++end;
    const std::string_view symbol = unit.substr(at, end - at);
    if (!is_unit(symbol)) {
      const std::string_view plain = without_prefix(symbol);
      if (!plain.empty()) return fmt::format("{} is not an SI unit; give it in {}", in_quotes(symbol), plain);
      return fmt::format("unit {} is not understood; write one of {} with whole exponents, or 1",
                         in_quotes(unit), fmt::join(kUnits, ", "));
    }
    any = true;
    if (end < unit.size() && unit[end] == '^') ++end;
    if (end < unit.size() && unit[end] == '-') ++end;
    while (end < unit.size() && is_digit(unit[end])) ++end;
    at = end;
  }
  const bool complete = any && unit.back() != '/' && unit.back() != '^' && unit.back() != '-';
  return complete ? std::string() : fmt::format("unit {} is not complete", in_quotes(unit));
}

}  // namespace slipstack::workbench
