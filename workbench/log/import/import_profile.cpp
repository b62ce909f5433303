// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/import_profile.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <sstream>
#include <utility>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kFormat = "slipstack import 1";

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

struct UnitTarget {
  const char* unit;
  const char* target;
  double factor;
};

// Where the log knows the unit itself, the numbers stay as they are.
constexpr std::array kTimes{UnitTarget{"s", "time_s", 1.0},   UnitTarget{"sec", "time_s", 1.0},
                            UnitTarget{"ms", "time_s", 1e-3}, UnitTarget{"us", "time_s", 1e-6},
                            UnitTarget{"µs", "time_s", 1e-6}, UnitTarget{"ns", "time_s", 1e-9}};
constexpr std::array kPositions{
    UnitTarget{"m", "position_m", 1.0},        UnitTarget{"mm", "position_mm", 1.0},
    UnitTarget{"um", "position_um", 1.0},      UnitTarget{"µm", "position_um", 1.0},
    UnitTarget{"nm", "position_um", 1e-3},     UnitTarget{"counts", "position_counts", 1.0},
    UnitTarget{"inc", "position_counts", 1.0}, UnitTarget{"rad", "position_rad", 1.0},
    UnitTarget{"deg", "position_deg", 1.0},    UnitTarget{"°", "position_deg", 1.0},
    UnitTarget{"rev", "position_rev", 1.0}};
constexpr std::array kForces{UnitTarget{"n", "force_N", 1.0},     UnitTarget{"mn", "force_mN", 1.0},
                             UnitTarget{"un", "force_uN", 1.0},   UnitTarget{"kn", "force_N", 1e3},
                             UnitTarget{"nm", "torque_Nm", 1.0},  UnitTarget{"mnm", "torque_mNm", 1.0},
                             UnitTarget{"n m", "torque_Nm", 1.0}, UnitTarget{"n·m", "torque_Nm", 1.0}};
constexpr std::array kCurrents{UnitTarget{"a", "current_A", 1.0}, UnitTarget{"ma", "current_A", 1e-3}};
constexpr std::array kVelocities{
    UnitTarget{"m/s", "velocity_mps", 1.0},     UnitTarget{"mm/s", "velocity_mps", 1e-3},
    UnitTarget{"um/s", "velocity_mps", 1e-6},   UnitTarget{"rad/s", "velocity_radps", 1.0},
    UnitTarget{"deg/s", "velocity_degps", 1.0}, UnitTarget{"rpm", "velocity_revps", 1.0 / 60.0}};
constexpr std::array kTemperatures{UnitTarget{"°c", "temperature_C", 1.0},
                                   UnitTarget{"c", "temperature_C", 1.0}};

/// Whole words of a name, and units that may stand at its end without brackets.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : lower(name)) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || (static_cast<unsigned char>(c) & 0x80U) != 0) {
      words.back() += c;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

/// The unit in "[mm]", "(mm)", or after " / ".
std::string bracketed_unit(const std::string& name) {
  for (const auto& [open, close] : {std::pair{'[', ']'}, std::pair{'(', ')'}}) {
    const std::size_t begin = name.find(open);
    const std::size_t end = name.find(close, begin);
    if (begin != std::string::npos && end != std::string::npos) {
      return std::string(trimmed(std::string_view(name).substr(begin + 1, end - begin - 1)));
    }
  }
  const std::size_t slash = name.find(" / ");
  return slash == std::string::npos ? "" : std::string(trimmed(std::string_view(name).substr(slash + 3)));
}

enum class Kind { none, time, position, reference, force, current, velocity, temperature };

Kind kind_of(const std::vector<std::string>& words) {
  const auto any = [&](std::initializer_list<const char*> known) {
    return std::any_of(known.begin(), known.end(), [&](const char* word) {
      return std::find(words.begin(), words.end(), word) != words.end();
    });
  };
  if (any({"time", "t", "zeit", "timestamp", "zeitstempel", "clock"})) return Kind::time;
  if (any({"temperature", "temp", "temperatur"})) return Kind::temperature;
  const bool wanted =
      any({"set", "setpoint", "reference", "ref", "command", "cmd", "soll", "demand", "target"});
  if (any({"velocity", "speed", "vel", "v", "geschwindigkeit"})) return wanted ? Kind::none : Kind::velocity;
  if (any({"current", "iq", "strom", "i", "amps"})) return Kind::current;
  if (any({"force", "kraft", "f", "fx", "torque", "moment", "drehmoment", "load"})) return Kind::force;
  if (any({"position", "pos", "x", "weg", "lage", "encoder", "enc", "angle", "winkel", "phi", "actpos",
           "displacement", "istposition", "sollposition"})) {
    return wanted || any({"sollposition"}) ? Kind::reference : Kind::position;
  }
  return Kind::none;
}

template <std::size_t N>
std::optional<ImportColumn> by_unit(const std::array<UnitTarget, N>& units, const std::string& unit) {
  for (const UnitTarget& one : units) {
    if (lower(unit) == one.unit) return ImportColumn{"", one.target, one.factor, false};
  }
  return {};
}

template <std::size_t N>
ImportColumn chosen(const std::array<UnitTarget, N>& units, const std::string& unit,
                    const std::vector<std::string>& words) {
  if (const auto found = by_unit(units, unit)) return *found;
  if (unit.empty() && words.size() > 1) {
    if (const auto found = by_unit(units, words.back())) return *found;
  }
  return {"", units[0].target, units[0].factor, false};
}

char one_character(const toml::table& table, const char* key, char otherwise, const std::string& name) {
  const std::string text = table[key].value_or(std::string(1, otherwise));
  if (text.size() != 1) throw InputError(fmt::format("{}: {} must be one character", name, key));
  return text[0];
}

}  // namespace

ImportColumn guess_column(const std::string& name, const std::string& unit) {
  const std::string bracketed = unit.empty() ? bracketed_unit(name) : unit;
  const std::string plain = name.substr(0, std::min(name.find_first_of("[("), name.find(" / ")));
  const std::vector<std::string> words = words_of(plain);
  ImportColumn column;
  switch (kind_of(words)) {
    case Kind::time:
      column = chosen(kTimes, bracketed, words);
      break;
    case Kind::position:
      column = chosen(kPositions, bracketed, words);
      break;
    case Kind::reference:
      column = chosen(kPositions, bracketed, words);
      if (column.target == "position_um" || column.target == "position_counts") {
        column = {};  // no such column in a log
      } else if (column.target == "position_mm") {
        column = {"", "reference_position_m", 1e-3, false};
      } else {
        column.target = "reference_" + column.target;
      }
      break;
    case Kind::force:
      column = chosen(kForces, bracketed, words);
      break;
    case Kind::current:
      column = chosen(kCurrents, bracketed, words);
      break;
    case Kind::velocity:
      column = chosen(kVelocities, bracketed, words);
      break;
    case Kind::temperature:
      column = chosen(kTemperatures, bracketed, words);
      break;
    case Kind::none:
      break;
  }
  column.source = name;
  return column;
}

void assign_columns(ImportProfile& profile, const std::string& text) {
  for (ImportColumn& column : profile.columns) column.target.clear();
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
      profile.columns.push_back({(*one)["source"].value_or(std::string()),
                                 (*one)["target"].value_or(std::string()), (*one)["factor"].value_or(1.0),
                                 (*one)["iso_time"].value_or(false)});
    }
  }
  return profile;
}

}  // namespace slipstack::workbench
