// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/csv/columns.h"

#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

// What a column is of: an axis of any kind, or of one.
enum class Of { any, linear, rotary };

struct KnownColumn {
  std::string_view quantity_name;
  std::string_view unit;
  Quantity quantity;
  Of of;
  double divisor = 1.0;  // dividing by 10ⁿ rounds once, multiplying by 10⁻ⁿ would round twice
  double factor = 1.0;   // angles
  bool counts = false;

  std::string name() const { return std::string(quantity_name) + "_" + std::string(unit); }
};

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kRevolution = 2.0 * std::numbers::pi;

constexpr std::array kKnownColumns{
    KnownColumn{"time", "s", Quantity::kTime, Of::any},
    KnownColumn{"position", "m", Quantity::kPosition, Of::linear},
    KnownColumn{"position", "mm", Quantity::kPosition, Of::linear, 1e3},
    KnownColumn{"position", "um", Quantity::kPosition, Of::linear, 1e6},
    KnownColumn{"position", "counts", Quantity::kPosition, Of::any, 1.0, 1.0, true},
    KnownColumn{"position", "rad", Quantity::kPosition, Of::rotary},
    KnownColumn{"position", "deg", Quantity::kPosition, Of::rotary, 1.0, kDegree},
    KnownColumn{"position", "rev", Quantity::kPosition, Of::rotary, 1.0, kRevolution},
    KnownColumn{"force", "N", Quantity::kForce, Of::linear},
    KnownColumn{"force", "mN", Quantity::kForce, Of::linear, 1e3},
    KnownColumn{"force", "uN", Quantity::kForce, Of::linear, 1e6},
    KnownColumn{"torque", "Nm", Quantity::kForce, Of::rotary},
    KnownColumn{"torque", "mNm", Quantity::kForce, Of::rotary, 1e3},
    KnownColumn{"current", "A", Quantity::kCurrent, Of::any},
    KnownColumn{"reference_position", "m", Quantity::kReferencePosition, Of::linear},
    KnownColumn{"reference_position", "rad", Quantity::kReferencePosition, Of::rotary},
    KnownColumn{"reference_position", "deg", Quantity::kReferencePosition, Of::rotary, 1.0, kDegree},
    KnownColumn{"reference_position", "rev", Quantity::kReferencePosition, Of::rotary, 1.0, kRevolution},
    KnownColumn{"velocity", "mps", Quantity::kVelocity, Of::linear},
    KnownColumn{"velocity", "radps", Quantity::kVelocity, Of::rotary},
    KnownColumn{"velocity", "degps", Quantity::kVelocity, Of::rotary, 1.0, kDegree},
    KnownColumn{"velocity", "revps", Quantity::kVelocity, Of::rotary, 1.0, kRevolution},
    KnownColumn{"normal_force", "N", Quantity::kNormalForce, Of::any},
    KnownColumn{"temperature", "C", Quantity::kTemperature, Of::any},
};

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
    throw InputError(where + " is unknown; rename or remove it, or use `slipstack import`, which assigns " +
                     "other names and units (known columns: " + known_names() + ")");
  }
  if (match == name) throw InputError(where + " names no unit; write one of " + known_names(match));
  throw InputError(where + ": unknown unit " + in_quotes(name.substr(match.size() + 1)) +
                   "; convert it to one of " + known_names(match) +
                   ", or use `slipstack import`, which assigns other names and units");
}

/// The kind of axis that columns and header keys name; the first that names one decides.
class KindOfAxis {
 public:
  explicit KindOfAxis(const RawTable& table) : table_(table) {}

  void take(AxisKind kind, const std::string& name) {
    if (first_.empty()) {
      kind_ = kind;
      first_ = name;
    }
    if (kind == kind_) return;
    const bool rotary = kind == AxisKind::rotary;
    throw InputError(table_.where_names() + ": " + name + " is of a " + (rotary ? "rotary" : "linear") +
                     " axis, " + first_ + " of a " + (rotary ? "linear" : "rotary") +
                     " one; give all of them for one kind of axis");
  }
  AxisKind kind() const { return kind_; }

 private:
  const RawTable& table_;
  AxisKind kind_ = AxisKind::linear;
  std::string first_;
};

/// Angles are shown in the unit of the position's column.
AngleUnit shown_of(const KnownColumn& position) {
  if (position.unit == "deg") return AngleUnit::degree;
  return position.unit == "rev" ? AngleUnit::revolution : AngleUnit::radian;
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
    throw InputError(where + ": a force column is missing; add one of " + known_names("force") + ", " +
                     known_names("torque") + ", or " + known_names("current") +
                     " with '# motor_constant_N_per_A: value' (rotary: motor_constant_Nm_per_A)" + found);
  }
}

void require_header_for_columns(const RawTable& table, const ColumnPlan& plan, const HeaderValues& header) {
  if (plan[Quantity::kPosition]->counts && !header.encoder_resolution_m) {
    throw InputError(table.where_names() +
                     ": column position_counts needs the encoder's step; add the header line "
                     "'# encoder_resolution_m: value' (rotary: encoder_resolution_rad)");
  }
  if (!plan[Quantity::kForce] && !header.motor_constant_N_per_A) {
    throw InputError(table.where_names() +
                     ": column current_A needs the motor constant; add the header line "
                     "'# motor_constant_N_per_A: value' (rotary: motor_constant_Nm_per_A)");
  }
}

}  // namespace

ColumnPlan plan_columns(const RawTable& table, const HeaderValues& header) {
  ColumnPlan plan;
  KindOfAxis axis(table);
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
    source = ColumnPlan::Source{i, known->divisor, known->factor, known->counts};
    if (known->of != Of::any)
      axis.take(known->of == Of::rotary ? AxisKind::rotary : AxisKind::linear, "column " + name);
    if (known->quantity == Quantity::kPosition) plan.axis.shown = shown_of(*known);
  }
  for (const auto& [key, kind] : header.kinds) axis.take(kind, "header key " + key);
  plan.axis.kind = axis.kind();
  require_columns(table, plan);
  require_header_for_columns(table, plan, header);
  return plan;
}

}  // namespace slipstack::workbench
