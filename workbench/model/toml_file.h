// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <toml++/toml.h>
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace slipstack::workbench {

/// Names from a file are shortened to this in messages.
inline constexpr std::size_t kLongestName = 80;

/// The name under `key`, safe for a terminal.
std::string name_in(const toml::table& table, std::string_view key);

/// A TOML file of a model, and the checks of its entries. Every member throws InputError, one line with file
/// and line number, for what is wrong.
class TomlFile {
 public:
  explicit TomlFile(std::filesystem::path path) : path_(std::move(path)) {}
  /// A file whose content is in memory.
  TomlFile(std::filesystem::path name, std::string text) : path_(std::move(name)), text_(std::move(text)) {}

  toml::table parse() const;
  /// The file's name, for messages.
  std::string name() const;
  [[noreturn]] void fail(const toml::node& where, const std::string& what) const;
  /// Refuses a key that is not known. Keys with a unit are given as those of a linear axis (axis_units.h).
  void require_keys(const toml::table& table, std::initializer_list<std::string_view> known) const;
  /// Requires that every [[effect.<kind>]] is a table with a known name that no other has.
  void require_entries(const toml::table& effect, std::string_view kind,
                       std::vector<std::string_view> known) const;
  /// The [[effect.<kind>]] of this name, which must have this unit.
  const toml::table& find_entry(const toml::table& effect, std::string_view kind, std::string_view name,
                                std::string_view unit) const;
  /// Reads the numbers of `key` into `out` and returns how many there are. Only the elements of the
  /// hysteresis may be fewer than `out` holds, since not all need to be used; the others are left unchanged.
  std::size_t read_values(const toml::table& entry, std::string_view key, double lower, double upper,
                          std::span<double> out) const;

 private:
  void require_model_file() const;
  double number(const toml::node& node, const std::string& name, double lower, double upper) const;

  std::filesystem::path path_;
  std::optional<std::string> text_;
};

}  // namespace slipstack::workbench
