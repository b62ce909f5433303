// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <toml++/toml.h>
#include <sstream>

#include "workbench/base/axis_units.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

/// One value as a number, several as an array.
void put_values(toml::table& table, std::string_view key, std::span<const double> values) {
  if (values.size() == 1) {
    table.insert(key, values[0]);
    return;
  }
  toml::array array;
  for (const double value : values) array.push_back(value);
  table.insert(key, std::move(array));
}

/// Consecutive shapes of one name (slip distances) become one entry.
toml::array shapes_of(const Term& term, std::size_t used) {
  toml::array entries;
  const auto& specs = term.effect->shapes;
  for (std::size_t i = 0; i < specs.size();) {
    std::size_t end = i + 1;
    while (end < specs.size() && std::string_view(specs[end].name) == specs[i].name) ++end;
    toml::table entry{{"name", specs[i].name}, {"unit", axis_unit(specs[i].unit)}};
    const std::size_t count = std::min(end, std::max(used, i + 1)) - i;
    put_values(entry, "value", std::span(term.shapes).subspan(i, count));
    if (term.shape_standard_error(i) > 0.0) {
      put_values(entry, "standard_error", std::span(term.shape_standard_errors).subspan(i, count));
    }
    entries.push_back(std::move(entry));
    i = end;
  }
  return entries;
}

toml::array gains_of(const Term& term, std::size_t used) {
  toml::array entries;
  std::size_t first = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const std::size_t count = std::min(static_cast<std::size_t>(group.count), std::max<std::size_t>(used, 1));
    toml::table entry{{"name", group.name}, {"unit", axis_unit(group.unit)}};
    put_values(entry, "value", std::span(term.gains).subspan(first, count));
    if (term.gain_standard_errors.size() == term.gains.size()) {
      put_values(entry, "standard_error", std::span(term.gain_standard_errors).subspan(first, count));
    }
    if (term.lower[first] == term.upper[first]) entry.insert("given", true);
    entries.push_back(std::move(entry));
    first += static_cast<std::size_t>(group.count);
  }
  return entries;
}

toml::array effects_of(const Terms& terms) {
  toml::array effects;
  for (const Term& term : terms) {
    // Unused elements at the end are not written.
    std::size_t used = std::max(term.gains.size(), term.shapes.size());
    if (term.effect->has_role(Role::hysteresis)) {
      while (used > 1 && term.shapes[used - 1] == 0.0) --used;
    }
    toml::table effect{{"id", term.id()}};
    if (term.effect->is_user_defined()) effect.insert("definition", term.effect->definition);
    if (!term.shapes.empty()) effect.insert("shape", shapes_of(term, used));
    if (!term.gains.empty()) effect.insert("gain", gains_of(term, used));
    effects.push_back(std::move(effect));
  }
  return effects;
}

toml::array history_of(const Model& model) {
  toml::array changes;
  for (const Model::Change& change : model.history) {
    toml::table entry{{"date", change.date}, {"added", change.added}, {"log", change.log}};
    if (change.before_N > 0.0) entry.insert(axis_key("before_N"), change.before_N);
    entry.insert(axis_key("after_N"), change.after_N);
    entry.insert(axis_key("noise_floor_N"), change.noise_floor_N);
    changes.push_back(std::move(entry));
  }
  return changes;
}

toml::array user_effects_of(const Model& model) {
  toml::array entries;
  for (const Model::UserEffectOnTarget& effect : model.target_user_effects) {
    toml::table entry{{"id", effect.id}};
    if (effect.why_not.empty()) {
      entry.insert("over", effect.over);
      entry.insert("from", effect.from);
      entry.insert("to", effect.to);
      if (effect.reversal_velocity_mps > 0.0)
        entry.insert(axis_key("reversal_velocity_mps"), effect.reversal_velocity_mps);
      entry.insert(axis_key("largest_error_N"), effect.largest_error_N);
      entry.insert(axis_key("peak_N"), effect.peak_N);
    } else {
      entry.insert("left_out", effect.why_not);
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace

std::string to_toml(const Model& model) {
  toml::table file{{"format", "slipstack model 1"},
                   {"hash", fmt::format("{:08x}", target_hash(model))},
                   {"source", toml::table{{"log", model.source.log},
                                          {"samples", model.source.samples},
                                          {axis_key("holdout_rmse_N"), model.source.holdout_rmse_N},
                                          {axis_key("noise_floor_N"), model.source.noise_floor_N},
                                          {"relative_error", model.source.relative_error}}},
                   {"effect", effects_of(model.terms)},
                   {"target", toml::table{{axis_key("holdout_rmse_N"), model.target_holdout_rmse_N},
                                          {"effect", effects_of(model.target_terms)}}}};
  if (axis_is_rotary()) file.insert("axis", "rotary");
  if (!model.target_user_effects.empty()) file["target"].as_table()->insert("own", user_effects_of(model));
  if (!model.history.empty()) file.insert("history", history_of(model));
  std::ostringstream text;
  text
      << "# A slipstack friction model. `effect` is what was identified, `target` what the controller runs;\n"
         "# `hash` is what the controller reports for the latter.\n"
      << file << '\n';
  return text.str();
}

}  // namespace slipstack::workbench
