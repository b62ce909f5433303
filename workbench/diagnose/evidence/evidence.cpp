// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "workbench/base/quantity.h"
#include "workbench/model/effects/shape_parameter.h"

namespace slipstack::workbench {
namespace {

/// The value of the placeholder `name`: a shape, a single gain, or the amplitude of a group of gains (of
/// cosine and sine gains that of the strongest harmonic; of a map its largest absolute value).
std::string value_of(const Term& term, std::string_view name) {
  for (std::size_t i = 0; i < term.effect->shapes.size(); ++i) {
    const ShapeSpec& shape = term.effect->shapes[i];
    if (name == shape.name) return shape_value(shape, term.shapes[i]);
  }
  std::size_t first = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const auto count = static_cast<std::size_t>(group.count);
    if (name != group.name) {
      first += count;
      continue;
    }
    if (count == 1) {  // of each log, where each has its own gains
      std::string values;
      for (std::size_t g = first; g < term.gains.size(); g += term.gains_per_set()) {
        values += (values.empty() ? "" : " / ") + quantity(term.gains[g], group.unit);
      }
      return values;
    }
    double largest = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double own = std::abs(term.gains[first + i]);
      const bool paired = !group.smooth && i % 2 == 0 && i + 1 < count;
      largest = std::max(largest, paired ? std::hypot(own, term.gains[first + i + 1]) : own);
    }
    return quantity(largest, group.unit);
  }
  return std::string(name);
}

/// Gains that ended at a bound other than zero: the log did not determine them, the bound did. Given gains
/// and those of elements that are not used do not count.
std::string gains_at_bounds(const Term& term) {
  std::string text;
  std::size_t first = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const auto count = static_cast<std::size_t>(group.count);
    std::size_t at_bound = 0;
    for (std::size_t i = first; i < first + count && i < term.gains.size(); ++i) {
      const double gain = term.gains[i];
      const bool bounded = gain == term.lower[i] || gain == term.upper[i];
      if (bounded && gain != 0.0 && term.lower[i] != term.upper[i]) ++at_bound;
    }
    first += count;
    if (at_bound == 0) continue;
    text += count == 1 ? fmt::format("; {} is at its bound, not identified", group.name)
                       : fmt::format("; {} of {} values of {} are at their bound, not identified", at_bound,
                                     count, group.name);
  }
  return text;
}

}  // namespace

std::string evidence_of(const Term& fitted) {
  std::string text;
  const std::string_view pattern = fitted.effect->text.evidence;
  std::size_t at = 0;
  std::size_t described = 0;  // end of the last value that was inserted
  while (at < pattern.size()) {
    const std::size_t open = pattern.find('{', at);
    const std::size_t close = open == std::string_view::npos ? open : pattern.find('}', open);
    if (close == std::string_view::npos) break;
    text += pattern.substr(at, open - at);
    const std::string value = value_of(fitted, pattern.substr(open + 1, close - open - 1));
    const std::size_t clause = text.rfind(", ");
    at = close + 1;
    if (value.starts_with("0 ") && clause != std::string::npos && clause >= described && described > 0) {
      // A further clause with the value zero ("the viscous slope by 0 N s/m") is left out.
      text.resize(clause);
      at = std::min(pattern.find(", ", at), pattern.size());
      continue;
    }
    text += value;
    described = text.size();
  }
  text += pattern.substr(at);
  return text + gains_at_bounds(fitted);
}

}  // namespace slipstack::workbench
