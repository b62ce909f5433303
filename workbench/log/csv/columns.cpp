// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/csv/columns.h"

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

struct KnownColumn {
  std::string_view quantity_name;
  std::string_view unit;
  Quantity quantity;
  double divisor;  // dividing by 10ⁿ rounds once, multiplying by 10⁻ⁿ would round twice
  bool counts = false;

  std::string name() const { return std::string(quantity_name) + "_" + std::string(unit); }
};

constexpr std::array<KnownColumn, 13> kKnownColumns{{
    {"time", "s", Quantity::kTime, 1.0},
    {"position", "m", Quantity::kPosition, 1.0},
    {"position", "mm", Quantity::kPosition, 1e3},
    {"position", "um", Quantity::kPosition, 1e6},
    {"position", "counts", Quantity::kPosition, 1.0, true},
    {"force", "N", Quantity::kForce, 1.0},
    {"force", "mN", Quantity::kForce, 1e3},
    {"force", "uN", Quantity::kForce, 1e6},
    {"current", "A", Quantity::kCurrent, 1.0},
    {"reference_position", "m", Quantity::kReferencePosition, 1.0},
    {"velocity", "mps", Quantity::kVelocity, 1.0},
    {"normal_force", "N", Quantity::kNormalForce, 1.0},
    {"temperature", "C", Quantity::kTemperature, 1.0},
}};

// "position_m, position_mm, ...": the columns of one quantity, or of all.
std::string known_names(std::string_view quantity_name = {}) {
  std::vector<std::string> names;
  for (const KnownColumn& known : kKnownColumns) {
    if (quantity_name.empty() || known.quantity_name == quantity_name) names.push_back(known.name());
  }
  return joined(names);
}

const KnownColumn* find_known(std::string_view name) {
  for (const KnownColumn& known : kKnownColumns) {
    if (known.name() == name) return &known;
  }
  return nullptr;
}

[[noreturn]] void refuse_unknown_column(const RawTable& table, std::string_view name) {
  const std::string where = table.where_names() + ": column " + in_quotes(name);
  // The quantity that the name starts with; the longest one where several match.
  std::string_view match;
  for (const KnownColumn& known : kKnownColumns) {
    const std::string_view quantity = known.quantity_name;
    const bool alone = name == quantity;
    const bool with_unit = name.starts_with(quantity) && name.substr(quantity.size()).starts_with('_');
    if ((alone || with_unit) && quantity.size() > match.size()) match = quantity;
  }
  if (match.empty()) {
    throw InputError(where + " is unknown; rename or remove it (known columns: " + known_names() + ")");
  }
  if (match == name) throw InputError(where + " names no unit; write one of " + known_names(match));
  throw InputError(where + ": unknown unit " + in_quotes(name.substr(match.size() + 1)) +
                   "; convert it to one of " + known_names(match));
}

void require_columns(const RawTable& table, const ColumnPlan& plan) {
  const std::string where = table.where_names();
  std::vector<std::string> names;
  for (const auto& column : table.columns) names.push_back(printable(column.name));
  const std::string found = " (found: " + joined(names) + ")";
  if (!plan[Quantity::kTime]) {
    throw InputError(where + ": column time_s is missing; add the time of each sample in seconds" + found);
  }
  if (!plan[Quantity::kPosition]) {
    throw InputError(where + ": a position column is missing; add one of " + known_names("position") + found);
  }
  if (!plan[Quantity::kForce] && !plan[Quantity::kCurrent]) {
    throw InputError(where + ": a force column is missing; add one of " + known_names("force") + ", or " +
                     known_names("current") + " with '# motor_constant_N_per_A: value'" + found);
  }
}

void require_header_for_columns(const RawTable& table, const ColumnPlan& plan, const HeaderValues& header) {
  if (plan[Quantity::kPosition]->counts && !header.encoder_resolution_m) {
    throw InputError(table.where_names() +
                     ": column position_counts needs the encoder's step; add the header line "
                     "'# encoder_resolution_m: value'");
  }
  if (!plan[Quantity::kForce] && !header.motor_constant_N_per_A) {
    throw InputError(table.where_names() +
                     ": column current_A needs the motor constant; add the header line "
                     "'# motor_constant_N_per_A: value'");
  }
}

}  // namespace

ColumnPlan plan_columns(const RawTable& table, const HeaderValues& header) {
  ColumnPlan plan;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const std::string& name = table.columns[i].name;
    const KnownColumn* const known = find_known(name);
    if (known == nullptr) refuse_unknown_column(table, name);
    auto& source = plan.sources[static_cast<std::size_t>(known->quantity)];
    if (source) {
      const std::string& first = table.columns[source->column].name;
      throw InputError(table.where_names() + ": column " + name +
                       (first == name ? " occurs twice; remove one of them"
                                      : " repeats what " + first + " gives; remove one of them"));
    }
    source = ColumnPlan::Source{i, known->divisor, known->counts};
  }
  require_columns(table, plan);
  require_header_for_columns(table, plan, header);
  return plan;
}

}  // namespace slipstack::workbench
