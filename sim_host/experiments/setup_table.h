// SPDX-License-Identifier: Apache-2.0
// A table of a set-up file with its line numbers, and a list of the keys that have been read.
#pragma once

#include <fmt/format.h>

#include <toml++/toml.h>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim_host/experiments/setup.h"

namespace slipstack::sim {

/// The range of a number; bounds are included unless stated.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool above_low = false;  // low itself is excluded
};
inline constexpr Range kAny{};
inline constexpr Range kPositive{0.0, std::numeric_limits<double>::infinity(), true};
inline constexpr Range kNotNegative{0.0};

/// Reads one table. Every accessor throws SetupError with file and line when the value is not valid; finish()
/// throws for keys that were not read.
class SetupTable {
 public:
  SetupTable(const toml::table& table, std::string path) : table_(table), path_(std::move(path)) {}

  bool has(std::string_view key) const { return table_.contains(key); }
  double number(std::string_view key, const Range& range);
  double number_or(std::string_view key, const Range& range, double otherwise);
  std::size_t count_or(std::string_view key, std::size_t least, std::size_t most, std::size_t otherwise);
  std::string text(std::string_view key);
  std::string text_or(std::string_view key, const std::string& otherwise);
  /// One of the given words; returns its index.
  std::size_t word(std::string_view key, const std::vector<std::string_view>& words);
  std::vector<double> numbers(std::string_view key, const Range& range);
  std::vector<double> numbers_or(std::string_view key, const Range& range, std::vector<double> otherwise);
  std::optional<SetupTable> table(std::string_view key);
  std::vector<SetupTable> tables(std::string_view key);
  void finish() const;
  /// Refuses the table, or one of its keys.
  [[noreturn]] void fail(const std::string& what, std::string_view key = {}) const;

 private:
  const toml::node* find(std::string_view key);
  double checked(const toml::node& node, std::string_view key, const Range& range) const;
  [[noreturn]] void fail_at(const toml::node& node, const std::string& what) const;

  const toml::table& table_;
  std::string path_;  // "[drive]", for messages
  std::set<std::string, std::less<>> asked_;
};

/// Effects of the catalogue, each a table of its own; without its table an effect does not exist.
void read_effects(SetupTable& file, Axis& axis);
VirginCurve read_curve(SetupTable& file);

}  // namespace slipstack::sim
