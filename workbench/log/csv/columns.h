// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "workbench/base/axis_units.h"
#include "workbench/log/csv/header_values.h"
#include "workbench/log/csv/raw_table.h"

namespace slipstack::workbench {

enum class Quantity : std::size_t {
  kTime,
  kPosition,
  kForce,
  kCurrent,
  kReferencePosition,
  kVelocity,
  kNormalForce,
  kTemperature,
};
inline constexpr std::size_t kQuantityCount = 8;

// Which column of a table holds which quantity, and how its numbers become SI units (rad and N m on a rotary
// axis).
struct ColumnPlan {
  AxisUnits axis;
  struct Source {
    std::size_t column = 0;
    double divisor = 1.0;
    double factor = 1.0;
    bool counts = false;  // encoder counts: to be multiplied by the encoder's resolution
  };
  std::array<std::optional<Source>, kQuantityCount> sources;

  const std::optional<Source>& operator[](Quantity quantity) const {
    return sources[static_cast<std::size_t>(quantity)];
  }
};

// Assigns a quantity to every column of the table. Throws InputError for a missing, unknown or repeated
// column, an unknown unit, a mix of a linear and a rotary axis, and a header that lacks a value that a column
// needs. Uses the names only, so that
// a wrong file is refused before its rows are read.
ColumnPlan plan_columns(const RawTable& table, const HeaderValues& header);

}  // namespace slipstack::workbench
