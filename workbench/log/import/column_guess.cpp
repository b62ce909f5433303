// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/column_guess.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

struct UnitTarget {
  const char* unit;
  const char* target;
  double factor;
};

// Where the log knows the unit itself, the numbers stay as they are.
constexpr std::array kTimes{UnitTarget{"s", "time_s", 1.0},       UnitTarget{"sec", "time_s", 1.0},
                            UnitTarget{"seconds", "time_s", 1.0}, UnitTarget{"ms", "time_s", 1e-3},
                            UnitTarget{"msec", "time_s", 1e-3},   UnitTarget{"us", "time_s", 1e-6},
                            UnitTarget{"usec", "time_s", 1e-6},   UnitTarget{"µs", "time_s", 1e-6},
                            UnitTarget{"ns", "time_s", 1e-9},     UnitTarget{"min", "time_s", 60.0},
                            UnitTarget{"h", "time_s", 3600.0},    UnitTarget{"hours", "time_s", 3600.0}};
constexpr std::array kPositions{
    UnitTarget{"m", "position_m", 1.0},           UnitTarget{"mm", "position_mm", 1.0},
    UnitTarget{"um", "position_um", 1.0},         UnitTarget{"µm", "position_um", 1.0},
    UnitTarget{"nm", "position_um", 1e-3},        UnitTarget{"cm", "position_mm", 10.0},
    UnitTarget{"in", "position_mm", 25.4},        UnitTarget{"inch", "position_mm", 25.4},
    UnitTarget{"counts", "position_counts", 1.0}, UnitTarget{"inc", "position_counts", 1.0},
    UnitTarget{"rad", "position_rad", 1.0},       UnitTarget{"deg", "position_deg", 1.0},
    UnitTarget{"°", "position_deg", 1.0},         UnitTarget{"rev", "position_rev", 1.0}};
constexpr std::array kForces{UnitTarget{"n", "force_N", 1.0},
                             UnitTarget{"mn", "force_mN", 1.0},
                             UnitTarget{"un", "force_uN", 1.0},
                             UnitTarget{"kn", "force_N", 1e3},
                             UnitTarget{"lbf", "force_N", 4.4482216152605},  // NIST SP 811
                             UnitTarget{"kgf", "force_N", 9.80665},          // the same
                             UnitTarget{"ncm", "torque_Nm", 1e-2},
                             UnitTarget{"nm", "torque_Nm", 1.0},
                             UnitTarget{"mnm", "torque_mNm", 1.0},
                             UnitTarget{"n m", "torque_Nm", 1.0},
                             UnitTarget{"n·m", "torque_Nm", 1.0}};
constexpr std::array kCurrents{UnitTarget{"a", "current_A", 1.0}, UnitTarget{"ma", "current_A", 1e-3}};
constexpr std::array kVelocities{UnitTarget{"m/s", "velocity_mps", 1.0},
                                 UnitTarget{"mm/s", "velocity_mps", 1e-3},
                                 UnitTarget{"um/s", "velocity_mps", 1e-6},
                                 UnitTarget{"m/min", "velocity_mps", 1.0 / 60.0},
                                 UnitTarget{"mm/min", "velocity_mps", 1e-3 / 60.0},
                                 UnitTarget{"rad/s", "velocity_radps", 1.0},
                                 UnitTarget{"deg/s", "velocity_degps", 1.0},
                                 UnitTarget{"rpm", "velocity_revps", 1.0 / 60.0}};
constexpr std::array kTemperatures{UnitTarget{"°c", "temperature_C", 1.0},
                                   UnitTarget{"c", "temperature_C", 1.0}};

/// Whole words of a name, and units that may stand at its end without brackets.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : lower_case(name)) {
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
  if (any({"velocity", "speed", "vel", "v", "actvelo", "actvel", "geschwindigkeit"}))
    return wanted ? Kind::none : Kind::velocity;
  if (any({"current", "iq", "strom", "i", "amps", "actcurrent"})) return Kind::current;
  if (any({"force", "kraft", "f", "fx", "torque", "moment", "drehmoment", "load", "acttorque", "actforce"}))
    return Kind::force;
  if (any({"position", "pos", "x", "weg", "lage", "encoder", "enc", "angle", "winkel", "phi", "actpos",
           "displacement", "istposition", "sollposition"})) {
    return wanted || any({"sollposition"}) ? Kind::reference : Kind::position;
  }
  return Kind::none;
}

template <std::size_t N>
std::optional<ImportColumn> by_unit(const std::array<UnitTarget, N>& units, const std::string& unit) {
  // Mega, not milli, or a program that writes in capitals: 10^9 apart, so it is asked for.
  if (unit.starts_with("MN") || unit.starts_with("MA")) return {};
  for (const UnitTarget& one : units) {
    if (lower_case(unit) == one.unit) return ImportColumn{"", one.target, one.factor, false};
  }
  return {};
}

/// By its unit; where a name has none, as if it were SI. A unit that is not known makes no column: a factor
/// would be wrong.
template <std::size_t N>
ImportColumn chosen(const std::array<UnitTarget, N>& units, const std::string& unit,
                    const std::vector<std::string>& words) {
  if (const auto found = by_unit(units, unit)) return *found;
  const bool is_unit = !unit.empty() && unit.find(' ') == std::string::npos;  // "(load side)" is none
  if (is_unit) return {};
  if (words.size() > 1) {
    if (const auto found = by_unit(units, words.back())) return *found;
  }
  return {"", units[0].target, units[0].factor, false};
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

}  // namespace slipstack::workbench
