// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "workbench/base/axis_units.h"
#include "workbench/log/csv/raw_table.h"

namespace slipstack::workbench {

/// The values of the header keys that the workbench uses; absent ones are empty. Those of a rotary axis
/// (inertia_kg_m2, motor_constant_Nm_per_A, magnet_pitch_rad, encoder_resolution_rad) stand in the same
/// places.
struct HeaderValues {
  std::optional<double> mass_kg;
  std::optional<double> motor_constant_N_per_A;
  std::optional<double> magnet_pitch_m;
  std::optional<double> encoder_resolution_m;
  bool irregular_sampling = false;
  std::vector<std::pair<std::string, AxisKind>>
      kinds;  ///< each key above that is there, and its kind of axis
  bool commanded_current = false;
};

/// Reads the known header keys. Throws InputError for a value that is not a number or out of its range, for a
/// known quantity in a unit that is not known, and for a `sampling` or `current_source` that is
/// none of theirs.
HeaderValues read_header_values(const RawTable& table);

}  // namespace slipstack::workbench
