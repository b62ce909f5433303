// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/setup_table.h"

#include <fmt/ranges.h>

namespace slipstack::sim {
namespace {

std::string bounds_text(const Range& range) {
  if (std::isfinite(range.low) && std::isfinite(range.high)) {
    return fmt::format("lie in {}{:g}, {:g}]", range.above_low ? '(' : '[', range.low, range.high);
  }
  if (std::isfinite(range.low))
    return fmt::format("be {} {:g}", range.above_low ? "above" : "at least", range.low);
  return fmt::format("be at most {:g}", range.high);
}

}  // namespace

void SetupTable::fail_at(const toml::node& node, const std::string& what) const {
  const toml::source_region& source = node.source();
  throw SetupError(fmt::format("{}:{}: {}", source.path ? *source.path : "set-up", source.begin.line, what));
}

void SetupTable::fail(const std::string& what, std::string_view key) const {
  const toml::node* node = table_.get(key);
  fail_at(node != nullptr ? *node : table_, path_.empty() ? what : fmt::format("{} {}", path_, what));
}

const toml::node* SetupTable::find(std::string_view key) {
  asked_.emplace(key);
  return table_.get(key);
}

double SetupTable::checked(const toml::node& node, std::string_view key, const Range& range) const {
  const auto value = node.value<double>();
  if (!value || !std::isfinite(*value)) {
    fail_at(node, fmt::format("{} is not a finite number; write one", key));
  }
  const bool low = range.above_low ? *value <= range.low : *value < range.low;
  if (low || *value > range.high) {
    fail_at(node, fmt::format("{} = {:g} cannot be; it must {}", key, *value, bounds_text(range)));
  }
  return *value;
}

double SetupTable::number(std::string_view key, const Range& range) {
  const toml::node* node = find(key);
  if (node == nullptr) fail(fmt::format("has no {}; add the line {} = value", key, key));
  return checked(*node, key, range);
}

double SetupTable::number_or(std::string_view key, const Range& range, double otherwise) {
  const toml::node* node = find(key);
  return node == nullptr ? otherwise : checked(*node, key, range);
}

std::size_t SetupTable::count_or(std::string_view key, std::size_t least, std::size_t most,
                                 std::size_t otherwise) {
  const toml::node* node = find(key);
  if (node == nullptr) return otherwise;
  if (!node->is_integer()) fail_at(*node, fmt::format("{} is not a whole number; write one", key));
  const double value = checked(*node, key, {static_cast<double>(least), static_cast<double>(most)});
  return static_cast<std::size_t>(value);
}

std::string SetupTable::text(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) fail(fmt::format("has no {}; add the line {} = \"...\"", key, key));
  if (!node->is_string()) fail_at(*node, fmt::format("{} is not a text; put it into quotes", key));
  return node->value_or<std::string>("");
}

std::string SetupTable::text_or(std::string_view key, const std::string& otherwise) {
  return has(key) ? text(key) : otherwise;
}

std::size_t SetupTable::word(std::string_view key, const std::vector<std::string_view>& words) {
  const std::string chosen = text(key);
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == chosen) return i;
  }
  fail_at(*table_.get(key), fmt::format("{} = \"{}\" is none of {}", key, chosen, fmt::join(words, ", ")));
}

std::vector<double> SetupTable::numbers(std::string_view key, const Range& range) {
  const toml::node* node = find(key);
  if (node == nullptr) fail(fmt::format("has no {}; add the line {} = [value, ...]", key, key));
  const toml::array* array = node->as_array();
  if (array == nullptr || array->empty()) {
    fail_at(*node, fmt::format("{} is not a list of numbers; write [value, ...]", key));
  }
  std::vector<double> values;
  for (const toml::node& item : *array) values.push_back(checked(item, key, range));
  return values;
}

std::vector<double> SetupTable::numbers_or(std::string_view key, const Range& range,
                                           std::vector<double> otherwise) {
  return has(key) ? numbers(key, range) : std::move(otherwise);
}

std::optional<SetupTable> SetupTable::table(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const toml::table* inner = node->as_table();
  if (inner == nullptr) fail_at(*node, fmt::format("{} must be a table; write [{}]", key, key));
  return SetupTable(*inner, fmt::format("[{}]", key));
}

std::vector<SetupTable> SetupTable::tables(std::string_view key) {
  const toml::node* node = find(key);
  std::vector<SetupTable> found;
  if (node == nullptr) return found;
  const toml::array* array = node->as_array();
  if (array == nullptr || array->empty()) {
    fail_at(*node, fmt::format("{} must be a list of tables; write [[{}]]", key, key));
  }
  for (const toml::node& item : *array) {
    const toml::table* inner = item.as_table();
    if (inner == nullptr) fail_at(item, fmt::format("{} must be a list of tables; write [[{}]]", key, key));
    found.emplace_back(*inner, fmt::format("[[{}]]", key));
  }
  return found;
}

void SetupTable::finish() const {
  for (const auto& [key, node] : table_) {
    if (asked_.contains(key.str())) continue;
    fail_at(node, fmt::format("unknown key '{}'{}; known here: {}", key.str(),
                              path_.empty() ? "" : fmt::format(" in {}", path_), fmt::join(asked_, ", ")));
  }
}

}  // namespace slipstack::sim
