// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/evidence/evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "workbench/base/quantity.h"
#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/model/effects/shape_parameter.h"

namespace slipstack::workbench {
namespace {

/// Places at which a map is read to find its largest value: some ten in each of its intervals.
constexpr std::size_t kPlacesOfMap = 200;

/// The largest absolute value of a map over its travel, which is that of the log that it was fitted to. Its
/// gains are not its values: the first and the last spline reach a sixth of theirs at the ends of the travel,
/// so that a gain of -90 % there may be a map that nowhere leaves +-20 %.
double largest_of_map(const Term& term) {
  const auto at = [&](ShapeKind kind) {
    const auto& shapes = term.effect->shapes;
    const auto found = std::find_if(shapes.begin(), shapes.end(),
                                    [kind](const ShapeSpec& shape) { return shape.kind == kind; });
    return term.shapes[static_cast<std::size_t>(found - shapes.begin())];
  };
  std::vector<Sample<double>> samples(kPlacesOfMap + 1);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].position_m = at(ShapeKind::position) + at(ShapeKind::travel) * static_cast<double>(i) /
                                                          static_cast<double>(kPlacesOfMap);
  }
  const std::vector<double> gains(term.gains.begin(),
                                  term.gains.begin() + static_cast<std::ptrdiff_t>(term.gains_per_set()));
  const auto map =
      term.effect->make_force(term.shapes, gains, {.tick_s = 1.0, .metres_per_displacement = 1.0});
  map->reset(samples.front());
  std::vector<double> values(samples.size());
  map->run(samples, values.data());
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return std::max(-*low, *high);
}

bool is_map(const EffectDescription& effect) {
  return std::any_of(effect.shapes.begin(), effect.shapes.end(),
                     [](const ShapeSpec& shape) { return shape.kind == ShapeKind::travel; });
}

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
    if (is_map(*term.effect)) return quantity(largest_of_map(term), group.unit);
    double largest = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double own = std::abs(term.gains[first + i]);
      const bool paired = i % 2 == 0 && i + 1 < count;
      largest = std::max(largest, paired ? std::hypot(own, term.gains[first + i + 1]) : own);
    }
    return quantity(largest, group.unit);
  }
  return std::string(name);
}

/// Gains that ended at a bound other than zero: the log did not determine them, the bound did.
std::string gains_at_bounds(const Term& term, const Terms& model) {
  std::string text;
  std::size_t first = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const auto count = static_cast<std::size_t>(group.count);
    std::size_t at_bound = 0;
    for (std::size_t i = first; i < first + count && i < term.gains.size(); ++i)
      at_bound += gain_ended_at_bound(model, term, i) ? 1 : 0;
    first += count;
    if (at_bound == 0) continue;
    text += count == 1 ? fmt::format("; {} is at its bound, not identified", group.name)
                       : fmt::format("; {} of {} values of {} are at their bound, not identified", at_bound,
                                     count, group.name);
  }
  return text;
}

}  // namespace

std::string evidence_of(const Term& fitted, const Terms& model) {
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
  return text + gains_at_bounds(fitted, model);
}

}  // namespace slipstack::workbench
