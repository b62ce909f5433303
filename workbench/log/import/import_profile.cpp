// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/import_profile.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kFormat = "slipstack import 1";

char one_character(const toml::table& table, const char* key, char otherwise, const std::string& name) {
  const std::string text = table[key].value_or(std::string(1, otherwise));
  if (text.size() != 1) throw InputError(fmt::format("{}: {} must be one character", name, key));
  return text[0];
}

/// A key that nothing reads is a misspelt one: ignored, the log would be read otherwise than its profile
/// says.
void refuse_unknown_keys(const toml::table& table, const std::vector<std::string>& known,
                         const std::string& name) {
  for (const auto& [key, value] : table) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    throw InputError(fmt::format("{}:{}: unknown key {}; known here: {}", name, key.source().begin.line,
                                 in_quotes(key.str()), joined(known)));
  }
}

}  // namespace

void assign_columns(ImportProfile& profile, const std::string& text) {
  std::optional<ImportColumn> guessed_time;
  for (ImportColumn& column : profile.columns) {
    if (column.target == "time_s") guessed_time = column;
    column.target.clear();
  }
  for (const std::string_view field : split_fields(text)) {
    const std::size_t equals = field.rfind('=');
    if (equals == std::string_view::npos) {
      throw UsageError(fmt::format("--columns: {} is not NAME=TARGET, as x=position_mm", in_quotes(field)));
    }
    const std::string source(trimmed(field.substr(0, equals)));
    std::string target(trimmed(field.substr(equals + 1)));
    double factor = 1.0;
    if (const std::size_t star = target.find('*'); star != std::string::npos) {
      const std::string number(trimmed(std::string_view(target).substr(star + 1)));
      if (!number_fault(number).empty()) {
        throw UsageError(fmt::format("--columns: {} {}", in_quotes(number), number_fault(number)));
      }
      parse_double(number.data(), number.data() + number.size(), factor);
      target = std::string(trimmed(std::string_view(target).substr(0, star)));
    }
    auto column = std::find_if(profile.columns.begin(), profile.columns.end(),
                               [&](const ImportColumn& one) { return one.source == source; });
    if (column == profile.columns.end() && !source.empty() &&
        source.find_first_not_of("0123456789") == std::string::npos && source.size() < 4) {
      const auto index = static_cast<std::size_t>(std::stoi(source));
      if (index >= 1 && index <= profile.columns.size()) {
        column = profile.columns.begin() + static_cast<std::ptrdiff_t>(index - 1);
      }
    }
    if (column == profile.columns.end()) {
      std::vector<std::string> names;
      for (const ImportColumn& one : profile.columns) names.push_back(one.source);
      throw UsageError(fmt::format("--columns: no column {}; the file has {}", in_quotes(source),
                                   printable(joined(names), 400)));
    }
    column->target = target;
    column->factor = factor;
    column->same_time = false;
  }
  // Who names no time, and gives no rate, means the one that was recognised.
  const bool has_time =
      profile.sample_rate_Hz > 0.0 || std::any_of(profile.columns.begin(), profile.columns.end(),
                                                  [](const auto& one) { return one.target == "time_s"; });
  if (has_time || !guessed_time) return;
  for (ImportColumn& column : profile.columns) {
    if (column.source == guessed_time->source && column.target.empty()) {
      column = *guessed_time;
      return;
    }
  }
}

std::string to_toml(const ImportProfile& profile) {
  toml::table table{{"format", kFormat},
                    {"encoding", profile.encoding},
                    {"separator", std::string(1, profile.separator)},
                    {"decimal", std::string(1, profile.decimal)},
                    {"skip_lines", static_cast<std::int64_t>(profile.skip_lines)},
                    {"units_row", profile.units_row}};
  if (profile.sample_rate_Hz > 0.0) table.insert("sample_rate_Hz", profile.sample_rate_Hz);
  toml::table header;
  for (const auto& [key, value] : profile.header) header.insert(key, value);
  if (!header.empty()) table.insert("header", header);
  toml::array columns;
  for (const ImportColumn& column : profile.columns) {
    toml::table one{{"source", column.source}, {"target", column.target}};
    if (column.factor != 1.0) one.insert("factor", column.factor);
    if (column.iso_time) one.insert("iso_time", true);
    if (column.same_time) one.insert("same_time", true);
    columns.push_back(std::move(one));
  }
  table.insert("column", columns);
  std::ostringstream out;
  out << table << '\n';
  return out.str();
}

ImportProfile parse_profile(const std::string& name, std::string_view text) {
  toml::table table;
  try {
    table = toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}: {}", name, error.source().begin.line, error.description()));
  }
  if (table["format"].value_or(std::string()) != kFormat) {
    throw InputError(
        fmt::format("{}: not an import profile; its first line says format = '{}'", name, kFormat));
  }
  refuse_unknown_keys(table,
                      {"format", "encoding", "separator", "decimal", "skip_lines", "units_row",
                       "sample_rate_Hz", "header", "column"},
                      name);
  ImportProfile profile;
  profile.encoding = table["encoding"].value_or(profile.encoding);
  profile.separator = one_character(table, "separator", ',', name);
  profile.decimal = one_character(table, "decimal", '.', name);
  profile.skip_lines = static_cast<std::size_t>(
      std::clamp<std::int64_t>(table["skip_lines"].value_or(std::int64_t{0}), 0, 10000));
  profile.units_row = table["units_row"].value_or(false);
  profile.sample_rate_Hz = table["sample_rate_Hz"].value_or(0.0);
  if (const toml::table* header = table["header"].as_table()) {
    for (const auto& [key, value] : *header) {
      profile.header[std::string(key.str())] = printable(value.value_or(std::string()));
    }
  }
  if (const toml::array* columns = table["column"].as_array()) {
    for (const toml::node& node : *columns) {
      const toml::table* one = node.as_table();
      if (one == nullptr) throw InputError(fmt::format("{}: every [[column]] is a table", name));
      refuse_unknown_keys(*one, {"source", "target", "factor", "iso_time", "same_time"}, name);
      profile.columns.push_back({(*one)["source"].value_or(std::string()),
                                 (*one)["target"].value_or(std::string()), (*one)["factor"].value_or(1.0),
                                 (*one)["iso_time"].value_or(false), (*one)["same_time"].value_or(false)});
    }
  }
  return profile;
}

}  // namespace slipstack::workbench
