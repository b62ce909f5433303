// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>

#include "firmware/effects/presliding_hysteresis.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/model/effects/user_effect.h"
#include "workbench/model/expression/definition.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

constexpr std::uintmax_t kLargestFile = 16u << 20;

/// Names from a file are cut to this in messages.
constexpr std::size_t kLongestName = 80;

std::string name_in(const toml::table& table, std::string_view key) {
  return printable(table[key].value_or<std::string>(""), kLongestName);
}

/// Reads a model file, and knows where in it something is wrong.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {}

  Model read() {
    const toml::table file = parse();
    require_keys(file, {"format", "hash", "source", "history", "effect", "target"});
    if (file["format"].value_or<std::string>("") != "slipstack model 1") {
      fail(file, "no line format = \"slipstack model 1\"; give a file that `slipstack fit` or `add` wrote");
    }
    Model model;
    if (const toml::table* source = file["source"].as_table()) read_source(*source, model.source);
    read_history(file, model);
    model.terms = read_effects(file, kIdentifiedElements, false);
    const toml::table* target = file["target"].as_table();
    if (target == nullptr) fail(file, "table [target] is missing; fit the model again");
    require_keys(*target, {"holdout_rmse_N", "effect", "own"});
    model.target_terms = read_effects(*target, kTargetElements, true);
    read_own(*target, model);
    model.target_holdout_rmse_N = (*target)["holdout_rmse_N"].value_or(0.0);
    check_hash(file, model);
    return model;
  }

 private:
  [[noreturn]] void fail(const toml::node& where, const std::string& what) const {
    throw InputError(printable(fmt::format("{}:{}: {}", path_.string(), where.source().begin.line, what)));
  }

  toml::table parse() const {
    std::error_code error;
    if (!std::filesystem::exists(path_, error)) {
      throw InputError(fmt::format("{}: no such file; `slipstack fit` writes one", path_.string()));
    }
    if (!std::filesystem::is_regular_file(path_, error)) {
      throw InputError(
          fmt::format("{}: not a file; give a model written by `slipstack fit`", path_.string()));
    }
    if (std::filesystem::file_size(path_, error) > kLargestFile) {
      throw InputError(
          fmt::format("{}: larger than any model; give a file that `slipstack fit` wrote", path_.string()));
    }
    try {
      return toml::parse_file(path_.string());
    } catch (const toml::parse_error& problem) {
      throw InputError(fmt::format("{}:{}: not TOML: {}; mend the line or fit the model again",
                                   path_.string(), problem.source().begin.line,
                                   printable(problem.description(), 200)));
    }
  }

  void require_keys(const toml::table& table, std::initializer_list<std::string_view> known) const {
    for (const auto& [key, node] : table) {
      if (std::find(known.begin(), known.end(), key.str()) == known.end()) {
        fail(node, fmt::format("unknown key '{}'; known here: {}", printable(key.str(), kLongestName),
                               fmt::join(known, ", ")));
      }
    }
  }

  void read_source(const toml::table& table, Model::Source& source) const {
    require_keys(table, {"log", "samples", "holdout_rmse_N", "noise_floor_N", "relative_error"});
    source.log = table["log"].value_or<std::string>("");
    source.samples = table["samples"].value_or<std::int64_t>(0);
    source.holdout_rmse_N = table["holdout_rmse_N"].value_or(0.0);
    source.noise_floor_N = table["noise_floor_N"].value_or(0.0);
    source.relative_error = table["relative_error"].value_or(0.0);
  }

  void read_history(const toml::table& file, Model& model) const {
    const toml::node* node = file.get("history");
    if (node == nullptr) return;
    const toml::array* changes = node->as_array();
    if (changes == nullptr) fail(*node, "history must be an array of tables");
    for (const toml::node& item : *changes) {
      const toml::table* change = item.as_table();
      if (change == nullptr) fail(item, "a change of the history must be a table");
      require_keys(*change, {"date", "added", "log", "before_N", "after_N", "noise_floor_N"});
      model.history.push_back(
          {(*change)["date"].value_or<std::string>(""), (*change)["added"].value_or<std::string>(""),
           (*change)["log"].value_or<std::string>(""), (*change)["before_N"].value_or(0.0),
           (*change)["after_N"].value_or(0.0), (*change)["noise_floor_N"].value_or(0.0)});
    }
  }

  void read_own(const toml::table& target, Model& model) const {
    const toml::node* node = target.get("own");
    if (node == nullptr) return;
    const toml::array* entries = node->as_array();
    if (entries == nullptr) fail(*node, "own must be an array of tables");
    for (const toml::node& item : *entries) {
      const toml::table* own = item.as_table();
      if (own == nullptr) fail(item, "an own effect of the target must be a table");
      require_keys(*own, {"id", "left_out", "over", "from", "to", "reversal_velocity_mps", "largest_error_N",
                          "peak_N"});
      const auto value = [own](const char* key) { return (*own)[key].value_or(0.0); };
      model.target_user_effects.push_back(
          {(*own)["id"].value_or<std::string>(""), (*own)["left_out"].value_or<std::string>(""),
           (*own)["over"].value_or<std::string>(""), value("from"), value("to"),
           value("reversal_velocity_mps"), value("largest_error_N"), value("peak_N")});
    }
  }

  /// At most `elements` of hysteresis. Only a target has tables.
  Terms read_effects(const toml::table& table, std::size_t elements, bool target) const {
    const toml::array* effects = table["effect"].as_array();
    if (effects == nullptr || effects->empty()) fail(table, "no [[effect]]; a model has at least one");
    Terms terms;
    for (const toml::node& node : *effects) {
      const toml::table* effect = node.as_table();
      if (effect == nullptr) fail(node, "an effect must be a table");
      require_keys(*effect, {"id", "definition", "shape", "gain"});
      const auto id = (*effect)["id"].value<std::string>();
      if (!id) fail(*effect, "this effect has no id");
      const EffectDescription* description = effect->contains("definition") ? &read_definition(*effect, *id)
                                             : target && *id == controller_table().id() ? &controller_table()
                                                                                        : in_catalogue(*id);
      if (description == nullptr) {
        fail(*(*effect)["id"].node(),
             fmt::format("unknown effect '{}'; known: {}", printable(*id, kLongestName), known_effects()));
      }
      if (contains(terms, *id)) fail(*effect, fmt::format("effect '{}' appears twice", *id));
      terms.push_back(read_term(*effect, *description, elements));
    }
    return terms;
  }

  /// Names alone mean the catalogue: what a file says must not depend on what was declared before it was
  /// read.
  static const EffectDescription* in_catalogue(const std::string& id) {
    const EffectDescription* description = find_effect(id);
    return description == nullptr || description->is_user_defined() ? nullptr : description;
  }

  /// A user's own effect: declared by the file itself.
  const EffectDescription& read_definition(const toml::table& effect, const std::string& id) const {
    const toml::node& node = *effect.get("definition");
    const auto text = node.value<std::string>();
    if (!text) fail(node, "definition must be a text");
    try {
      const EffectDescription& description = declare_effect(*text);
      if (description.id() != id) {
        fail(node, fmt::format("the definition is of '{}', not of '{}'", description.id(),
                               printable(id, kLongestName)));
      }
      return description;
    } catch (const DefinitionError& error) {
      fail(node, fmt::format("definition, character {}: {}", error.column() + 1, error.what()));
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
      fail(table, fmt::format("{} slip distances and {} stiffnesses; each element has one of both",
                              slip_distances, stiffnesses));
    }
    if (stiffnesses > elements) {
      fail(table, fmt::format("{} elements; {} has {}; fit the model again", stiffnesses,
                              elements == kTargetElements ? "the controller" : "a model", elements));
    }
    return term;
  }

  /// Returns how many values the last shape had; runs of one name (slip distances) are one entry.
  std::size_t read_shapes(const toml::table& table, Term& term) const {
    const std::vector<ShapeSpec>& specs = term.effect->shapes;
    std::vector<std::string_view> names;
    names.reserve(specs.size());
    for (const ShapeSpec& spec : specs) names.emplace_back(spec.name);
    require_entries(table, "shape", names);
    std::size_t count = 0;
    for (std::size_t i = 0; i < specs.size();) {
      std::size_t end = i + 1;
      while (end < specs.size() && names[end] == names[i]) ++end;
      const toml::table& entry = find_entry(table, "shape", specs[i].name, specs[i].unit);
      require_keys(entry, {"name", "unit", "value", "standard_error"});
      count = read_values(entry, "value", static_cast<double>(specs[i].lower),
                          static_cast<double>(specs[i].upper), std::span(term.shapes).subspan(i, end - i));
      if (entry.contains("standard_error")) {
        term.shape_standard_errors.resize(specs.size(), 0.0);
        read_values(entry, "standard_error", 0.0, HUGE_VAL,
                    std::span(term.shape_standard_errors).subspan(i, end - i));
      }
      i = end;
    }
    return count;
  }

  /// Returns how many values the last gain had.
  std::size_t read_gains(const toml::table& table, Term& term) const {
    std::vector<std::string_view> names;
    for (const GainGroup& group : term.effect->gain_groups) names.emplace_back(group.name);
    require_entries(table, "gain", names);
    std::size_t first = 0;
    std::size_t values = 0;
    for (const GainGroup& group : term.effect->gain_groups) {
      const auto count = static_cast<std::size_t>(group.count);
      const auto lower = static_cast<double>(group.lower);
      const auto upper = static_cast<double>(group.upper);
      const toml::table& entry = find_entry(table, "gain", group.name, group.unit);
      require_keys(entry, {"name", "unit", "value", "standard_error", "given"});
      values = read_values(entry, "value", lower, upper, std::span(term.gains).subspan(first, count));
      const bool given = entry["given"].value_or(false);
      for (std::size_t i = first; i < first + count; ++i) {
        term.lower.push_back(given ? term.gains[i] : lower);
        term.upper.push_back(given ? term.gains[i] : upper);
      }
      if (entry.contains("standard_error")) {
        term.gain_standard_errors.resize(term.gains.size(), 0.0);
        read_values(entry, "standard_error", 0.0, HUGE_VAL,
                    std::span(term.gain_standard_errors).subspan(first, count));
      }
      first += count;
    }
    return values;
  }

  /// Every [[effect.<kind>]] is a table with a known name that no other has.
  void require_entries(const toml::table& effect, std::string_view kind,
                       std::vector<std::string_view> known) const {
    const toml::node* node = effect.get(kind);
    if (node == nullptr) return;
    const toml::array* entries = node->as_array();
    if (entries == nullptr) fail(*node, fmt::format("{} must be an array of tables", kind));
    known.erase(std::unique(known.begin(), known.end()), known.end());
    std::vector<std::string> seen;
    for (const toml::node& item : *entries) {
      const toml::table* entry = item.as_table();
      if (entry == nullptr) fail(item, fmt::format("a {} must be a table", kind));
      const auto name = (*entry)["name"].value_or<std::string>("");
      if (std::find(known.begin(), known.end(), name) == known.end()) {
        fail(*entry, fmt::format("unknown {} '{}' of effect '{}'; known: {}", kind, name_in(*entry, "name"),
                                 name_in(effect, "id"), fmt::join(known, ", ")));
      }
      if (std::find(seen.begin(), seen.end(), name) != seen.end()) {
        fail(*entry, fmt::format("{} '{}' appears twice", kind, name));
      }
      seen.push_back(name);
    }
  }

  const toml::table& find_entry(const toml::table& effect, std::string_view kind, std::string_view name,
                                std::string_view unit) const {
    const toml::array* entries = effect[kind].as_array();
    if (entries != nullptr) {
      for (const toml::node& node : *entries) {
        const toml::table* entry = node.as_table();
        if (entry == nullptr || (*entry)["name"].value_or<std::string>("") != name) continue;
        if ((*entry)["unit"].value_or<std::string>("") != unit) {
          fail(*entry, fmt::format("{} has unit '{}'; it must be '{}'", name, name_in(*entry, "unit"), unit));
        }
        return *entry;
      }
    }
    fail(effect, fmt::format("{} '{}' of effect '{}' is missing", kind, name,
                             effect["id"].value_or<std::string>("?")));
  }

  /// Numbers of `key` into `out`; returns how many. Fewer than it holds leave the rest zero, only for the
  /// elements of the hysteresis, which need not all be used.
  std::size_t read_values(const toml::table& entry, std::string_view key, double lower, double upper,
                          std::span<double> out) const {
    const toml::node* node = entry.get(key);
    const auto name = entry["name"].value_or<std::string>("?");
    if (node == nullptr) fail(entry, fmt::format("{} has no {}", name, key));
    std::vector<double> values;
    if (const toml::array* array = node->as_array()) {
      for (const toml::node& item : *array) values.push_back(number(item, name, lower, upper));
    } else {
      values.push_back(number(*node, name, lower, upper));
    }
    const bool elements = out.size() == static_cast<std::size_t>(kIdentifiedElements);
    if (values.empty() || values.size() > out.size() || (values.size() < out.size() && !elements)) {
      fail(*node, fmt::format("{} has {} values; it must have {}{}", name, values.size(),
                              elements ? "1 to " : "", out.size()));
    }
    std::copy(values.begin(), values.end(), out.begin());
    return values.size();
  }

  double number(const toml::node& node, const std::string& name, double lower, double upper) const {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value)) fail(node, fmt::format("{} is not a finite number", name));
    // Bounds are float: a decimal that means the bound may lie beyond it by half a float's last place.
    const double inside = std::clamp(*value, lower, upper);
    if (std::abs(*value - inside) > 1e-7 * std::abs(inside)) {
      fail(node, fmt::format("{} = {:g} is out of bounds; it must lie in [{:g}, {:g}]", name, *value, lower,
                             upper));
    }
    return inside;
  }

  void check_hash(const toml::table& file, const Model& model) const {
    const toml::node* node = file.get("hash");
    if (node == nullptr) return;
    const std::string expected = fmt::format("{:08x}", target_hash(model));
    if (node->value_or<std::string>("") != expected) {
      fail(*node,
           fmt::format("hash does not belong to the parameters under [target] (theirs is {}); fit again, or "
                       "delete the line if you changed them on purpose",
                       expected));
    }
  }

  std::filesystem::path path_;
};

}  // namespace

Model read_model(const std::filesystem::path& path) {
  return Reader(path).read();
}

}  // namespace slipstack::workbench
