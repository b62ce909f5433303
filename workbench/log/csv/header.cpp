// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/csv/header.h"

#include <array>
#include <string>
#include <string_view>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

enum class Range { kPositive, kNotNegative };

struct KnownKey {
  std::string_view quantity_name;
  std::string_view unit;
  Range range;
  std::optional<double> HeaderValues::*value;

  std::string name() const { return std::string(quantity_name) + "_" + std::string(unit); }
};

constexpr std::array<KnownKey, 4> kKnownKeys{{
    {"mass", "kg", Range::kNotNegative, &HeaderValues::mass_kg},
    {"motor_constant", "N_per_A", Range::kPositive, &HeaderValues::motor_constant_N_per_A},
    {"magnet_pitch", "m", Range::kPositive, &HeaderValues::magnet_pitch_m},
    {"encoder_resolution", "m", Range::kPositive, &HeaderValues::encoder_resolution_m},
}};

// Units that are refused. Any other ending (`mass_note`) makes a key of the user's own.
constexpr std::array<std::string_view, 18> kOtherUnits{
    "g",  "mg", "t",    "lb",     "kg",    "m",        "cm",       "mm",       "um",
    "nm", "in", "inch", "counts", "per_A", "mN_per_A", "N_per_mA", "Nm_per_A", "lbf_per_A"};

// Otherwise a key such as magnet_pitch_mm would be kept as a remark and its value silently ignored.
void refuse_other_unit(const RawTable& table, const std::string& key, const RawTable::HeaderEntry& entry) {
  for (const KnownKey& known : kKnownKeys) {
    if (key == known.name()) return;
    const std::string where = table.where_line(entry.line) + ": header key " + in_quotes(key);
    if (key == known.quantity_name) throw InputError(where + " names no unit; write " + known.name());
    for (const std::string_view unit : kOtherUnits) {
      if (key == std::string(known.quantity_name) + "_" + std::string(unit)) {
        throw InputError(where + ": unknown unit " + in_quotes(unit) + "; convert it to " + known.name());
      }
    }
  }
}

double read_header_number(const RawTable& table, const KnownKey& known, const RawTable::HeaderEntry& entry) {
  const std::string where = table.where_line(entry.line) + ": header key " + known.name();
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
  return value;
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
  for (const auto& [key, entry] : table.header) refuse_other_unit(table, key, entry);
  for (const KnownKey& known : kKnownKeys) {
    const auto entry = table.header.find(known.name());
    if (entry != table.header.end()) values.*known.value = read_header_number(table, known, entry->second);
  }
  values.irregular_sampling = is_second_choice(table, "sampling", "uniform", "irregular");
  values.commanded_current = is_second_choice(table, "current_source", "measured", "commanded");
  return values;
}

}  // namespace slipstack::workbench
