// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <toml++/toml.h>
#include <cmath>

#include "workbench/log/input_error.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

constexpr std::uintmax_t kLargestFile = 16u << 20;

/// Where something is wrong, for a message.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {}

  Model read() {
    const toml::table file = parse();
    require_keys(file, {"format", "hash", "source", "effect", "target"});
    if (file["format"].value_or<std::string>("") != "slipstack model 1") {
      fail(file, "no line format = \"slipstack model 1\"; give a file that `slipstack fit` or `add` wrote");
    }
    Model model;
    if (const toml::table* source = file["source"].as_table()) read_source(*source, model.source);
    model.terms = read_effects(file);
    const toml::table* target = file["target"].as_table();
    if (target == nullptr) fail(file, "table [target] is missing; fit the model again");
    model.target_terms = read_effects(*target);
    model.target_holdout_rmse_N = (*target)["holdout_rmse_N"].value_or(0.0);
    check_hash(file, model);
    return model;
  }

 private:
  [[noreturn]] void fail(const toml::node& where, const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", path_.string(), where.source().begin.line, what));
  }

  toml::table parse() const {
    std::error_code error;
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
      std::string description(problem.description());
      for (char& c : description) {
        if (static_cast<unsigned char>(c) < 0x20) c = ' ';
      }
      throw InputError(fmt::format("{}:{}: not TOML: {}; mend the line or fit the model again",
                                   path_.string(), problem.source().begin.line, description));
    }
  }

  void require_keys(const toml::table& table, std::initializer_list<std::string_view> known) const {
    for (const auto& [key, node] : table) {
      if (std::find(known.begin(), known.end(), key.str()) == known.end()) {
        fail(node, fmt::format("unknown key '{}'; known here: {}", key.str(), fmt::join(known, ", ")));
      }
    }
  }

  void read_source(const toml::table& table, Model::Source& source) const {
    source.log = table["log"].value_or<std::string>("");
    source.samples = table["samples"].value_or<std::int64_t>(0);
    source.holdout_rmse_N = table["holdout_rmse_N"].value_or(0.0);
    source.noise_floor_N = table["noise_floor_N"].value_or(0.0);
    source.relative_error = table["relative_error"].value_or(0.0);
  }

  Terms read_effects(const toml::table& table) const {
    const toml::array* effects = table["effect"].as_array();
    if (effects == nullptr || effects->empty()) fail(table, "no [[effect]]; a model has at least one");
    Terms terms;
    for (const toml::node& node : *effects) {
      const toml::table* effect = node.as_table();
      if (effect == nullptr) fail(node, "an effect must be a table");
      require_keys(*effect, {"id", "shape", "gain"});
      const auto id = (*effect)["id"].value<std::string>();
      if (!id) fail(*effect, "this effect has no id");
      const EffectDescription* description = find_effect(*id);
      if (description == nullptr) {
        fail(*(*effect)["id"].node(), fmt::format("unknown effect '{}'; known: {}", *id, known_effects()));
      }
      if (contains(terms, *id)) fail(*effect, fmt::format("effect '{}' appears twice", *id));
      terms.push_back(read_term(*effect, *description));
    }
    return terms;
  }

  Term read_term(const toml::table& table, const EffectDescription& effect) const {
    Term term;
    term.effect = &effect;
    term.shapes.assign(effect.shapes.size(), 0.0);
    term.gains.assign(static_cast<std::size_t>(effect.gain_count), 0.0);
    for (std::size_t i = 0; i < effect.shapes.size();) {
      std::size_t end = i + 1;
      while (end < effect.shapes.size() &&
             std::string_view(effect.shapes[end].name) == effect.shapes[i].name) {
        ++end;
      }
      const toml::table& entry = find_entry(table, "shape", effect.shapes[i].name, effect.shapes[i].unit);
      read_values(entry, "value", static_cast<double>(effect.shapes[i].lower),
                  static_cast<double>(effect.shapes[i].upper), std::span(term.shapes).subspan(i, end - i));
      i = end;
    }
    std::size_t first = 0;
    for (const GainGroup& group : effect.gain_groups) {
      const auto count = static_cast<std::size_t>(group.count);
      const toml::table& entry = find_entry(table, "gain", group.name, group.unit);
      read_values(entry, "value", static_cast<double>(group.lower), static_cast<double>(group.upper),
                  std::span(term.gains).subspan(first, count));
      const bool given = entry["given"].value_or(false);
      for (std::size_t i = first; i < first + count; ++i) {
        term.lower.push_back(given ? term.gains[i] : static_cast<double>(group.lower));
        term.upper.push_back(given ? term.gains[i] : static_cast<double>(group.upper));
      }
      if (entry.contains("standard_error")) {
        term.standard_errors.resize(term.gains.size(), 0.0);
        read_values(entry, "standard_error", 0.0, HUGE_VAL,
                    std::span(term.standard_errors).subspan(first, count));
      }
      first += count;
    }
    return term;
  }

  const toml::table& find_entry(const toml::table& effect, std::string_view kind, std::string_view name,
                                std::string_view unit) const {
    const toml::array* entries = effect[kind].as_array();
    if (entries != nullptr) {
      for (const toml::node& node : *entries) {
        const toml::table* entry = node.as_table();
        if (entry == nullptr || (*entry)["name"].value_or<std::string>("") != name) continue;
        require_keys(*entry, {"name", "unit", "value", "standard_error", "given"});
        const auto written = (*entry)["unit"].value_or<std::string>("");
        if (written != unit)
          fail(*entry, fmt::format("{} has unit '{}'; it must be '{}'", name, written, unit));
        return *entry;
      }
    }
    fail(effect, fmt::format("{} '{}' of effect '{}' is missing", kind, name,
                             effect["id"].value_or<std::string>("?")));
  }

  /// Numbers of `key` into `out`; fewer than it holds leave the rest zero only where it holds many (unused
  /// elements of the hysteresis).
  void read_values(const toml::table& entry, std::string_view key, double lower, double upper,
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
    const bool elements = name == "stiffness" || name == "slip_distance";
    if (values.empty() || values.size() > out.size() || (values.size() < out.size() && !elements)) {
      fail(*node, fmt::format("{} has {} values; it must have {}", name, values.size(), out.size()));
    }
    std::copy(values.begin(), values.end(), out.begin());
  }

  double number(const toml::node& node, const std::string& name, double lower, double upper) const {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value)) fail(node, fmt::format("{} is not a finite number", name));
    if (*value < lower || *value > upper) {
      fail(node, fmt::format("{} = {:g} is out of bounds; it must lie in [{:g}, {:g}]", name, *value, lower,
                             upper));
    }
    return *value;
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
