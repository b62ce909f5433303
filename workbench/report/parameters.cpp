// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/diagnose/evidence/bounds.h"
#include "workbench/estimate/uncertainty/friction_each_way.h"
#include "workbench/model/effect_adapters/shape_parameter.h"
#include "workbench/report/json_values.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

json parameter_json(const char* name, std::size_t index, bool numbered, double value, double error,
                    const char* unit, const std::string& note) {
  return {{"name", numbered ? fmt::format("{} {}", name, index + 1) : std::string(name)},
          {"value", number_json(value)},
          {"standard_error", error > 0.0 ? json(error) : json(nullptr)},
          {"unit", axis_unit(unit)},
          {"note", note}};
}

/// Why a gain has no standard error, the same in text and JSON; empty where it has one. One that the log does
/// not move (an asymmetry of viscous friction in a model without viscous friction) is at no bound.
std::string gain_note(const Term& term, std::size_t gain) {
  if (term.lower[gain] == term.upper[gain]) return "given";
  if (term.gains[gain] == term.lower[gain] || term.gains[gain] == term.upper[gain]) return "at its bound";
  return term.gain_standard_error(gain) > 0.0 ? "" : "not determined";
}

json term_json(const Term& term) {
  json list = json::array();
  const bool elements = term.effect->has_role(Role::hysteresis);
  if (!elements) {
    for (std::size_t i = 0; i < term.shapes.size(); ++i) {
      const double error = term.shape_standard_error(i);
      list.push_back(parameter_json(term.effect->shapes[i].name, i, false, term.shapes[i], error,
                                    term.effect->shapes[i].unit,
                                    shape_ended_at_bound(term, i) ? "at its bound" : "shape"));
    }
  }
  for (std::size_t g = 0; g < term.gains.size(); ++g) {
    const std::size_t own = g % term.gains_per_set();
    const GainGroup& group = term.effect->group_of_gain(static_cast<int>(own));
    if (elements && term.gains[g] == 0.0) continue;
    const std::string note =
        elements ? fmt::format("slip distance {}", quantity(term.shapes[own], "m")) : gain_note(term, g);
    const double error = elements || note.empty() ? term.gain_standard_error(g) : 0.0;
    list.push_back(parameter_json(group.name, own, group.count > 1, term.gains[g], error, group.unit, note));
    if (term.gain_sets() > 1) list.back()["log"] = g / term.gains_per_set() + 1;
  }
  json found{{"effect", term.id()},
             {"title", term.effect->text.title},
             {"formula", term.effect->text.formula},
             {"parameters", list}};
  for (std::size_t set = 0; elements && set < term.gain_sets(); ++set) {
    const double error_N = term.total_standard_error(set);
    json level{{"level_N", number_json(hysteresis_level_N(term, set))},
               {"standard_error_N", error_N > 0.0 ? json(error_N) : json(nullptr)}};
    if (term.gain_sets() > 1) level["log"] = set + 1;
    found["levels"].push_back(std::move(level));
  }
  return found;
}

/// Significant digits of a value: down to the second digit of its standard error; three where there is none.
int digits_known(double value, double error) {
  if (error <= 0.0 || value == 0.0) return 3;
  const double ratio = std::log10(std::abs(value)) - std::floor(std::log10(error));
  return std::clamp(static_cast<int>(std::floor(ratio)) + 2, 3, 8);
}

/// "19.30 +- 0.20 N": two standard errors to either side, where they are known.
std::string with_interval(double value, double standard_error, const char* unit) {
  return quantity_with_interval(value, 2.0 * standard_error, unit);
}

/// " (log 2)" where each log has its own gains.
std::string of_log(const Term& term, std::size_t gain) {
  return term.gain_sets() > 1 ? fmt::format(" (log {})", gain / term.gains_per_set() + 1) : "";
}

/// "level of 4 elements": the friction of a hysteresis in steady motion.
std::string name_of_level(const Term& term, std::size_t set) {
  const auto count = static_cast<std::ptrdiff_t>(term.gains_per_set());
  const auto first = term.gains.begin() + static_cast<std::ptrdiff_t>(set) * count;
  const auto used = std::count_if(first, first + count, [](double stiffness) { return stiffness > 0.0; });
  return fmt::format("level of {}{}", counted(static_cast<std::size_t>(used), "element"),
                     of_log(term, set * term.gains_per_set()));
}

/// "mass", of a rotary axis "moment of inertia"; any other gain by its own name.
const char* name_of_gain(const Term& term, const GainGroup& group) {
  return term.effect->has_role(Role::inertia) ? mass_word() : group.name;
}

}  // namespace

json parameters_json(const Terms& terms) {
  json list = json::array();
  for (const Term& term : terms) list.push_back(term_json(term));
  return list;
}

json friction_each_way_json(const FittedModel& fitted) {
  const Term* term = find_role(fitted.terms, Role::directional_friction);
  if (term == nullptr) return nullptr;
  const FrictionEachWay value = friction_each_way(fitted.terms, *term);
  const FrictionEachWay error = standard_errors_each_way(fitted, term->effect->text.id);
  const auto known = [](double own) { return own > 0.0 ? json(own) : json(nullptr); };
  return {{"forward",
           {{"dry_N", number_json(value.dry_forward_N)},
            {"dry_standard_error_N", known(error.dry_forward_N)},
            {"slope", number_json(value.slope_forward)},
            {"slope_standard_error", known(error.slope_forward)}}},
          {"backward",
           {{"dry_N", number_json(value.dry_backward_N)},
            {"dry_standard_error_N", known(error.dry_backward_N)},
            {"slope", number_json(value.slope_backward)},
            {"slope_standard_error", known(error.slope_backward)}}},
          {"slope_unit", axis_unit("N s/m")}};
}

std::string friction_each_way_line(const FittedModel& fitted) {
  const Term* term = find_role(fitted.terms, Role::directional_friction);
  if (term == nullptr) return "";
  const FrictionEachWay value = friction_each_way(fitted.terms, *term);
  const FrictionEachWay error = standard_errors_each_way(fitted, term->effect->text.id);
  std::string text = fmt::format("friction   dry {} forward, {} backward",
                                 with_interval(value.dry_forward_N, error.dry_forward_N, "N"),
                                 with_interval(value.dry_backward_N, error.dry_backward_N, "N"));
  if (value.slope_forward != 0.0 || value.slope_backward != 0.0) {
    text += fmt::format("; viscous {} forward, {} backward",
                        with_interval(value.slope_forward, error.slope_forward, "N s/m"),
                        with_interval(value.slope_backward, error.slope_backward, "N s/m"));
  }
  return text + " (+-: two standard errors)\n";
}

void add_friction_each_way(json& report, const FittedModel& fitted) {
  const json found = friction_each_way_json(fitted);
  if (found.is_null()) return;
  json rows = json::array();
  for (const char* way : {"forward", "backward"}) {
    const json& own = found[way];
    rows.push_back({way, with_interval(number_of(own["dry_N"]), number_of(own["dry_standard_error_N"]), "N"),
                    with_interval(number_of(own["slope"]), number_of(own["slope_standard_error"]), "N s/m")});
  }
  report["tables"].push_back(table_json(
      "Friction in steady motion", {{"Direction", false}, {"Dry friction", true}, {"Viscous", true}}, rows));
}

std::string values_text(const Terms& terms, const std::vector<std::string>& ids) {
  std::vector<std::string> values;
  for (const Term& term : terms) {
    if (std::find(ids.begin(), ids.end(), term.id()) == ids.end()) continue;
    if (term.effect->has_role(Role::hysteresis)) {
      for (std::size_t set = 0; set < term.gain_sets(); ++set) {
        values.push_back(name_of_level(term, set) + " " +
                         with_interval(hysteresis_level_N(term, set), term.total_standard_error(set), "N"));
      }
      continue;
    }
    for (std::size_t g = 0; g < term.gains.size(); ++g) {
      const GainGroup& group = term.effect->group_of_gain(static_cast<int>(g % term.gains_per_set()));
      if (group.count > 1) continue;
      const std::string note = gain_note(term, g);
      const double error = note.empty() ? term.gain_standard_error(g) : 0.0;
      values.push_back(fmt::format("{}{} {}{}", name_of_gain(term, group), of_log(term, g),
                                   with_interval(term.gains[g], error, group.unit),
                                   note.empty() ? "" : " (" + note + ")"));
    }
  }
  return fmt::format("{}", fmt::join(values, ", "));
}

std::string parameter_table(const Terms& terms) {
  std::string text =
      fmt::format("\n{:<32} {:<24} {:>14} {:>14}\n", "effect", "parameter", "value", "std. error");
  for (const Term& term : terms) {
    const bool elements = term.effect->has_role(Role::hysteresis);
    const std::size_t count = term.gains_per_set();
    if (elements) {
      for (std::size_t set = 0; set < term.gain_sets(); ++set) {
        const double level_N = hysteresis_level_N(term, set);
        const double error_N = term.total_standard_error(set);
        text += fmt::format("{:<32} {:<24} {:>14} {:>14}\n", term.id(), name_of_level(term, set),
                            quantity(level_N, "N", digits_known(level_N, error_N)),
                            error_N > 0.0 ? quantity(error_N, "N") : "not determined");
      }
      continue;
    }
    for (std::size_t i = 0; i < term.shapes.size(); ++i) {
      const ShapeSpec& shape = term.effect->shapes[i];
      const double error = term.shape_standard_error(i);
      text += fmt::format("{:<32} {:<24} {:>14} {:>14}\n", term.id(), shape.name,
                          shape_value(shape, term.shapes[i], digits_known(term.shapes[i], error)),
                          error > 0.0                     ? shape_value(shape, error)
                          : shape_ended_at_bound(term, i) ? "at its bound"
                                                          : "set");
    }
    for (std::size_t g = 0; g < term.gains.size(); ++g) {
      const GainGroup& group = term.effect->group_of_gain(static_cast<int>(g % count));
      const std::string name =
          (group.count > 1 ? fmt::format("{} {}", group.name, g % count + 1) : name_of_gain(term, group)) +
          of_log(term, g);
      const std::string note = gain_note(term, g);
      const double error = note.empty() ? term.gain_standard_error(g) : 0.0;
      text += fmt::format("{:<32} {:<24} {:>14} {:>14}\n", term.id(), name,
                          quantity(term.gains[g], group.unit, digits_known(term.gains[g], error)),
                          note.empty() ? quantity(error, group.unit) : note);
    }
  }
  return text;
}

}  // namespace slipstack::workbench
