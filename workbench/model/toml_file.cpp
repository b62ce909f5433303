// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/toml_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "firmware/effects/presliding_hysteresis.h"
#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

constexpr std::uintmax_t kLargestFile = 16u << 20;  ///< far above any model

}  // namespace

std::string name_in(const toml::table& table, std::string_view key) {
  return printable(table[key].value_or<std::string>(""), kLongestName);
}

void TomlFile::fail(const toml::node& where, const std::string& what) const {
  throw InputError(printable(fmt::format("{}:{}: {}", path_.string(), where.source().begin.line, what)));
}

toml::table TomlFile::parse() const {
  if (!text_) require_model_file();
  try {
    return text_ ? toml::parse(*text_, path_.string()) : toml::parse_file(path_.string());
  } catch (const toml::parse_error& problem) {
    throw InputError(fmt::format("{}:{}: not TOML: {}; correct the line or fit the model again",
                                 path_.string(), problem.source().begin.line,
                                 printable(problem.description(), 200)));
  }
}

void TomlFile::require_model_file() const {
  std::error_code error;
  if (!std::filesystem::exists(path_, error)) {
    throw InputError(fmt::format("{}: no such file; `slipstack fit` writes one", path_.string()));
  }
  if (!std::filesystem::is_regular_file(path_, error)) {
    throw InputError(fmt::format("{}: not a file; give a model written by `slipstack fit`", path_.string()));
  }
  if (std::filesystem::file_size(path_, error) > kLargestFile) {
    throw InputError(
        fmt::format("{}: larger than any model; give a file that `slipstack fit` wrote", path_.string()));
  }
}

std::string TomlFile::name() const {
  return printable(path_.string());
}

void TomlFile::require_keys(const toml::table& table, std::initializer_list<std::string_view> known) const {
  std::vector<std::string> names;
  for (const std::string_view name : known) names.push_back(axis_key(name));
  for (const auto& [key, node] : table) {
    if (std::find(names.begin(), names.end(), key.str()) == names.end()) {
      fail(node, fmt::format("unknown key '{}'; known here: {}", printable(key.str(), kLongestName),
                             fmt::join(names, ", ")));
    }
  }
}

void TomlFile::require_entries(const toml::table& effect, std::string_view kind,
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

const toml::table& TomlFile::find_entry(const toml::table& effect, std::string_view kind,
                                        std::string_view name, std::string_view unit) const {
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
  fail(effect,
       fmt::format("{} '{}' of effect '{}' is missing", kind, name, effect["id"].value_or<std::string>("?")));
}

std::size_t TomlFile::read_values(const toml::table& entry, std::string_view key, double lower, double upper,
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

double TomlFile::number(const toml::node& node, const std::string& name, double lower, double upper) const {
  const auto value = node.value<double>();
  if (!value || !std::isfinite(*value)) fail(node, fmt::format("{} is not a finite number", name));
  // Bounds are float: the decimal of a value at its bound may exceed it by half a unit in the last place of a
  // float.
  const double inside = std::clamp(*value, lower, upper);
  if (std::abs(*value - inside) > 1e-7 * std::abs(inside)) {
    fail(node,
         fmt::format("{} = {:g} is out of bounds; it must lie in [{:g}, {:g}]", name, *value, lower, upper));
  }
  return inside;
}

}  // namespace slipstack::workbench
