// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/csv/header_values.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <string>
#include <string_view>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

enum class Range { kPositive, kNotNegative };

struct KnownKey {
  std::string_view name;
  std::string_view unit;  ///< the end of the name
  Range range;
  std::optional<double> HeaderValues::*value;
  AxisKind kind;
  double divisor = 1.0;  ///< by 10^n rounds once, as for the columns
  double factor = 1.0;   ///< of angles

  std::string_view quantity() const { return name.substr(0, name.size() - unit.size() - 1); }
};

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kRevolution = 2.0 * std::numbers::pi;

/// Lengths and angles in the units that a position may have, so that a log can be written in one unit.
constexpr std::array<KnownKey, 16> kKnownKeys{{
    {"mass_kg", "kg", Range::kNotNegative, &HeaderValues::mass_kg, AxisKind::linear},
    {"motor_constant_N_per_A", "N_per_A", Range::kPositive, &HeaderValues::motor_constant_N_per_A,
     AxisKind::linear},
    {"magnet_pitch_m", "m", Range::kPositive, &HeaderValues::magnet_pitch_m, AxisKind::linear},
    {"encoder_resolution_m", "m", Range::kPositive, &HeaderValues::encoder_resolution_m, AxisKind::linear},
    {"magnet_pitch_mm", "mm", Range::kPositive, &HeaderValues::magnet_pitch_m, AxisKind::linear, 1e3},
    {"encoder_resolution_mm", "mm", Range::kPositive, &HeaderValues::encoder_resolution_m, AxisKind::linear,
     1e3},
    {"magnet_pitch_um", "um", Range::kPositive, &HeaderValues::magnet_pitch_m, AxisKind::linear, 1e6},
    {"encoder_resolution_um", "um", Range::kPositive, &HeaderValues::encoder_resolution_m, AxisKind::linear,
     1e6},
    {"inertia_kg_m2", "kg_m2", Range::kNotNegative, &HeaderValues::mass_kg, AxisKind::rotary},
    {"motor_constant_Nm_per_A", "Nm_per_A", Range::kPositive, &HeaderValues::motor_constant_N_per_A,
     AxisKind::rotary},
    {"magnet_pitch_rad", "rad", Range::kPositive, &HeaderValues::magnet_pitch_m, AxisKind::rotary},
    {"encoder_resolution_rad", "rad", Range::kPositive, &HeaderValues::encoder_resolution_m,
     AxisKind::rotary},
    {"magnet_pitch_deg", "deg", Range::kPositive, &HeaderValues::magnet_pitch_m, AxisKind::rotary, 1.0,
     kDegree},
    {"encoder_resolution_deg", "deg", Range::kPositive, &HeaderValues::encoder_resolution_m, AxisKind::rotary,
     1.0, kDegree},
    {"magnet_pitch_rev", "rev", Range::kPositive, &HeaderValues::magnet_pitch_m, AxisKind::rotary, 1.0,
     kRevolution},
    {"encoder_resolution_rev", "rev", Range::kPositive, &HeaderValues::encoder_resolution_m, AxisKind::rotary,
     1.0, kRevolution},
}};

// Units that are refused. Any other ending (`mass_note`) makes a key of the user's own.
constexpr std::array<std::string_view, 20> kOtherUnits{
    "g",      "mg",     "t",    "lb",     "kg",    "m",        "cm",       "nm",    "in",        "inch",
    "arcmin", "counts", "kg_m", "kg_cm2", "per_A", "mN_per_A", "N_per_mA", "g_cm2", "lbf_per_A", "mrad"};

// Otherwise a key such as Mass_kg would be kept as a remark and its value silently ignored.
void refuse_other_letters(const RawTable& table, const std::string& key, const RawTable::HeaderEntry& entry) {
  const std::string lower = lower_case(key);
  for (const KnownKey& known : kKnownKeys) {
    if (key == known.name || lower != lower_case(known.name)) continue;
    throw InputError(table.where_line(entry.line) + ": header key " + in_quotes(key) +
                     " has other capitals; write " + std::string(known.name));
  }
}

// The same for a key such as magnet_pitch_in, in any letters.
void refuse_other_unit(const RawTable& table, const std::string& key, const RawTable::HeaderEntry& entry) {
  const std::string lower = lower_case(key);
  const auto is_known = [&](const KnownKey& known) { return key == known.name; };
  if (std::any_of(kKnownKeys.begin(), kKnownKeys.end(), is_known)) return;
  const std::string where = table.where_line(entry.line) + ": header key " + in_quotes(key);
  for (const KnownKey& known : kKnownKeys) {
    const std::string quantity(known.quantity());
    if (lower == lower_case(quantity))
      throw InputError(where + " names no unit; write " + std::string(known.name));
    for (const std::string_view unit : kOtherUnits) {
      const bool angle = unit == "arcmin" || unit == "mrad";
      if (lower != lower_case(quantity + "_" + std::string(unit)) ||
          (angle && known.kind == AxisKind::linear))
        continue;
      throw InputError(where + ": unknown unit " + in_quotes(unit) + "; convert it to " +
                       std::string(known.name));
    }
  }
}

double read_header_number(const RawTable& table, const KnownKey& known, const RawTable::HeaderEntry& entry) {
  const std::string where = table.where_line(entry.line) + ": header key " + std::string(known.name);
  const std::string fault = number_fault(entry.value);
  if (!fault.empty()) {
    throw InputError(where + ": " + fault + "; write a decimal number or remove the line");
  }
  double value = 0.0;
  parse_double(entry.value.data(), entry.value.data() + entry.value.size(), value);
  if (value < 0.0) {
    throw InputError(where + ": " + in_quotes(entry.value) +
                     " is negative; write a positive number or remove the line");
  }
  if (value == 0.0 && known.range == Range::kPositive) {
    throw InputError(where + " is zero; write a positive number or remove the line");
  }
  return value / known.divisor * known.factor;
}

// A key with two values, of which the first is meant where the key is absent.
bool is_second_choice(const RawTable& table, const std::string& key, const std::string& first,
                      const std::string& second) {
  const auto found = table.header.find(key);
  if (found == table.header.end()) return false;
  const RawTable::HeaderEntry& entry = found->second;
  if (entry.value != first && entry.value != second) {
    throw InputError(table.where_line(entry.line) + ": header key " + key + ": " + in_quotes(entry.value) +
                     " is unknown; write " + first + " or " + second);
  }
  return entry.value == second;
}

}  // namespace

HeaderValues read_header_values(const RawTable& table) {
  HeaderValues values;
  for (const auto& [key, entry] : table.header) {
    refuse_other_letters(table, key, entry);
    refuse_other_unit(table, key, entry);
  }
  for (const KnownKey& known : kKnownKeys) {
    const auto entry = table.header.find(std::string(known.name));
    if (entry == table.header.end()) continue;
    if (values.*known.value && known.kind == values.kinds.back().second) {
      throw InputError(table.where_line(entry->second.line) + ": header key " + std::string(known.name) +
                       " repeats what another gives; remove one of them");
    }
    values.*known.value = read_header_number(table, known, entry->second);
    values.kinds.emplace_back(known.name, known.kind);
  }
  values.irregular_sampling = is_second_choice(table, "sampling", "uniform", "irregular");
  values.commanded_current = is_second_choice(table, "current_source", "measured", "commanded");
  return values;
}

}  // namespace slipstack::workbench
