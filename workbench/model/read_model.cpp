// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "firmware/effects/presliding_hysteresis.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/effect_adapters/shape_parameter.h"
#include "workbench/model/effect_adapters/user_effect.h"
#include "workbench/model/expression/definition.h"
#include "workbench/model/model.h"
#include "workbench/model/toml_file.h"

namespace slipstack::workbench {
namespace {

class Reader {
 public:
  explicit Reader(TomlFile file) : file_(std::move(file)) {}

  Model read() {
    const toml::table file = file_.parse();
    file_.require_keys(file, {"format", "axis", "hash", "source", "history", "effect", "target"});
    if (file["format"].value_or<std::string>("") != "slipstack model 1") {
      file_.fail(file,
                 "no line format = \"slipstack model 1\"; give a file that `slipstack fit` or `add` wrote");
    }
    read_axis(file);
    Model model;
    if (const toml::table* source = file["source"].as_table()) read_source(*source, model.source);
    read_history(file, model);
    model.terms = read_effects(file, kIdentifiedElements, false);
    const toml::table* target = file["target"].as_table();
    if (target == nullptr) file_.fail(file, "table [target] is missing; fit the model again");
    file_.require_keys(*target, {"holdout_rmse_N", "effect", "own"});
    model.target_terms = read_effects(*target, kTargetElements, true);
    read_user_effects(*target, model);
    model.target_holdout_rmse_N = (*target)[axis_key("holdout_rmse_N")].value_or(0.0);
    check_hash(file, model);
    return model;
  }

 private:
  /// Before all that has a unit.
  void read_axis(const toml::table& file) const {
    const auto axis = file["axis"].value_or<std::string>("linear");
    if (axis != "linear" && axis != "rotary") {
      file_.fail(*file.get("axis"),
                 fmt::format("axis '{}' is neither linear nor rotary", printable(axis, kLongestName)));
    }
    use_axis({axis == "rotary" ? AxisKind::rotary : AxisKind::linear, AngleUnit::radian}, file_.name());
  }

  void read_source(const toml::table& table, Model::Source& source) const {
    file_.require_keys(table, {"log", "samples", "holdout_rmse_N", "noise_floor_N", "relative_error"});
    source.log = table["log"].value_or<std::string>("");
    source.samples = table["samples"].value_or<std::int64_t>(0);
    source.holdout_rmse_N = table[axis_key("holdout_rmse_N")].value_or(0.0);
    source.noise_floor_N = table[axis_key("noise_floor_N")].value_or(0.0);
    source.relative_error = table["relative_error"].value_or(0.0);
  }

  void read_history(const toml::table& file, Model& model) const {
    const toml::node* node = file.get("history");
    if (node == nullptr) return;
    const toml::array* changes = node->as_array();
    if (changes == nullptr) file_.fail(*node, "history must be an array of tables");
    for (const toml::node& item : *changes) {
      const toml::table* change = item.as_table();
      if (change == nullptr) file_.fail(item, "a change of the history must be a table");
      file_.require_keys(*change, {"date", "added", "log", "before_N", "after_N", "noise_floor_N"});
      model.history.push_back(
          {(*change)["date"].value_or<std::string>(""), (*change)["added"].value_or<std::string>(""),
           (*change)["log"].value_or<std::string>(""), (*change)[axis_key("before_N")].value_or(0.0),
           (*change)[axis_key("after_N")].value_or(0.0), (*change)[axis_key("noise_floor_N")].value_or(0.0)});
    }
  }

  void read_user_effects(const toml::table& target, Model& model) const {
    const toml::node* node = target.get("own");
    if (node == nullptr) return;
    const toml::array* entries = node->as_array();
    if (entries == nullptr) file_.fail(*node, "own must be an array of tables");
    for (const toml::node& item : *entries) {
      const toml::table* effect = item.as_table();
      if (effect == nullptr) file_.fail(item, "a user-defined effect of the target must be a table");
      file_.require_keys(*effect, {"id", "left_out", "over", "from", "to", "reversal_velocity_mps",
                                   "largest_error_N", "peak_N"});
      const auto value = [effect](const char* key) { return (*effect)[axis_key(key)].value_or(0.0); };
      model.target_user_effects.push_back(
          {(*effect)["id"].value_or<std::string>(""), (*effect)["left_out"].value_or<std::string>(""),
           (*effect)["over"].value_or<std::string>(""), value("from"), value("to"),
           value("reversal_velocity_mps"), value("largest_error_N"), value("peak_N")});
    }
  }

  /// `elements`: the largest number of hysteresis elements. `target`: whether a table is allowed.
  Terms read_effects(const toml::table& table, std::size_t elements, bool target) const {
    const toml::array* effects = table["effect"].as_array();
    if (effects == nullptr || effects->empty()) file_.fail(table, "no [[effect]]; a model has at least one");
    Terms terms;
    for (const toml::node& node : *effects) {
      const toml::table* effect = node.as_table();
      if (effect == nullptr) file_.fail(node, "an effect must be a table");
      file_.require_keys(*effect, {"id", "definition", "shape", "gain"});
      const auto id = (*effect)["id"].value<std::string>();
      if (!id) file_.fail(*effect, "this effect has no id");
      const EffectDescription* description = effect->contains("definition") ? &read_definition(*effect, *id)
                                             : target && *id == controller_table().id() ? &controller_table()
                                                                                        : in_catalogue(*id);
      if (description == nullptr) {
        file_.fail(*(*effect)["id"].node(), fmt::format("unknown effect '{}'; known: {}",
                                                        printable(*id, kLongestName), known_effects()));
      }
      if (contains(terms, *id)) file_.fail(*effect, fmt::format("effect '{}' appears twice", *id));
      terms.push_back(read_term(*effect, *description, elements));
    }
    return terms;
  }

  /// An id without a definition means the catalogue: the meaning of a file must not depend on effects that
  /// were declared before it was read.
  static const EffectDescription* in_catalogue(const std::string& id) {
    const EffectDescription* description = find_effect(id);
    return description == nullptr || description->is_user_defined() ? nullptr : description;
  }

  /// A user-defined effect is declared by the file itself.
  const EffectDescription& read_definition(const toml::table& effect, const std::string& id) const {
    const toml::node& node = *effect.get("definition");
    const auto text = node.value<std::string>();
    if (!text) file_.fail(node, "definition must be a text");
    try {
      const EffectDescription& description = declare_effect(*text);
      if (description.id() != id) {
        file_.fail(node, fmt::format("the definition is of '{}', not of '{}'", description.id(),
                                     printable(id, kLongestName)));
      }
      return description;
    } catch (const DefinitionError& error) {
      file_.fail(node, fmt::format("definition, character {}: {}", error.column() + 1, error.what()));
    }
  }

  Term read_term(const toml::table& table, const EffectDescription& effect, std::size_t elements) const {
    Term term;
    term.effect = &effect;
    term.shapes.assign(effect.shapes.size(), 0.0);
    term.gains.assign(static_cast<std::size_t>(effect.gain_count), 0.0);
    const std::size_t slip_distances = read_shapes(table, term);
    const std::size_t stiffnesses = read_gains(table, term);
    if (!effect.has_role(Role::hysteresis)) return term;
    if (slip_distances != stiffnesses) {
      file_.fail(table, fmt::format("{} slip distances and {} stiffnesses; each element has one of both",
                                    slip_distances, stiffnesses));
    }
    if (stiffnesses > elements) {
      file_.fail(table, fmt::format("{} elements; {} has {}; fit the model again", stiffnesses,
                                    elements == kTargetElements ? "the controller" : "a model", elements));
    }
    return term;
  }

  /// Returns the number of values of the last shape; consecutive shapes of one name (slip distances) are one
  /// entry.
  std::size_t read_shapes(const toml::table& table, Term& term) const {
    const std::vector<ShapeSpec>& specs = term.effect->shapes;
    std::vector<std::string_view> names;
    names.reserve(specs.size());
    for (const ShapeSpec& spec : specs) names.emplace_back(spec.name);
    file_.require_entries(table, "shape", names);
    std::size_t count = 0;
    for (std::size_t i = 0; i < specs.size();) {
      std::size_t end = i + 1;
      while (end < specs.size() && names[end] == names[i]) ++end;
      const toml::table& entry = file_.find_entry(table, "shape", specs[i].name, axis_unit(specs[i].unit));
      file_.require_keys(entry, {"name", "unit", "value", "standard_error"});
      const ShapeBounds bounds = bounds_of(specs[i]);
      count = file_.read_values(entry, "value", bounds.lower, bounds.upper,
                                std::span(term.shapes).subspan(i, end - i));
      if (entry.contains("standard_error")) {
        term.shape_standard_errors.resize(specs.size(), 0.0);
        file_.read_values(entry, "standard_error", 0.0, HUGE_VAL,
                          std::span(term.shape_standard_errors).subspan(i, end - i));
      }
      i = end;
    }
    return count;
  }

  /// Returns the number of values of the last gain.
  std::size_t read_gains(const toml::table& table, Term& term) const {
    std::vector<std::string_view> names;
    for (const GainGroup& group : term.effect->gain_groups) names.emplace_back(group.name);
    file_.require_entries(table, "gain", names);
    std::size_t first = 0;
    std::size_t values = 0;
    for (const GainGroup& group : term.effect->gain_groups) {
      const auto count = static_cast<std::size_t>(group.count);
      const auto lower = static_cast<double>(group.lower);
      const auto upper = static_cast<double>(group.upper);
      const toml::table& entry = file_.find_entry(table, "gain", group.name, axis_unit(group.unit));
      file_.require_keys(entry, {"name", "unit", "value", "standard_error", "given"});
      values = file_.read_values(entry, "value", lower, upper, std::span(term.gains).subspan(first, count));
      const bool given = entry["given"].value_or(false);
      for (std::size_t i = first; i < first + count; ++i) {
        term.lower.push_back(given ? term.gains[i] : lower);
        term.upper.push_back(given ? term.gains[i] : upper);
      }
      if (entry.contains("standard_error")) {
        term.gain_standard_errors.resize(term.gains.size(), 0.0);
        file_.read_values(entry, "standard_error", 0.0, HUGE_VAL,
                          std::span(term.gain_standard_errors).subspan(first, count));
      }
      first += count;
    }
    return values;
  }

  void check_hash(const toml::table& file, const Model& model) const {
    const toml::node* node = file.get("hash");
    if (node == nullptr) return;
    const std::string expected = fmt::format("{:08x}", target_hash(model));
    if (node->value_or<std::string>("") != expected) {
      file_.fail(
          *node,
          fmt::format("hash does not belong to the parameters under [target] (theirs is {}); fit again, or "
                      "delete the line if you changed them on purpose",
                      expected));
    }
  }

  TomlFile file_;
};

}  // namespace

Model read_model(const std::filesystem::path& path) {
  return Reader(TomlFile(path)).read();
}

Model read_model(const std::string& name, const std::optional<std::string>& content) {
  return Reader(content ? TomlFile(name, *content) : TomlFile(name)).read();
}

Model read_controller_model(const std::filesystem::path& path) {
  Model model = read_model(path);
  if (axis_is_rotary()) {
    throw InputError(
        fmt::format("{}: is of a rotary axis, and the controller works in m, N and kg; deploy a model of a "
                    "linear axis",
                    printable(path.string())));
  }
  return model;
}

}  // namespace slipstack::workbench
