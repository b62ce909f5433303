// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "workbench/model/model.h"

namespace slipstack::workbench {

struct FrictionHeaderOptions {
  bool is_float = true;           ///< what the controller computes; false: the workbench's model in double
  std::string name = "friction";  ///< begin of all names, an identifier of C
  /// Unit of position_steps in float [m, rad]; without, one in which the slip distances have many steps.
  std::optional<double> step_m;
  std::optional<double> rate_Hz;  ///< calls of step() per second, for effects that depend on it
};

/// A self-contained C99 header, which is C++ too: state, init and step of what the controller runs of a
/// model. The C text is recorded from the effects' own code (recorded.h). Compiled without contraction into
/// fused products it computes the force of the firmware bit for bit, but for the sign of a zero
/// (tests/unit/c_export). For a rotary axis (axis_units.h) the names say rad and N m. Throws InputError, one
/// line without a place, for an effect that cannot be recorded, a step that does not hold the slip distances,
/// and a rate that is missing.
std::string friction_header(const Model& model, const FrictionHeaderOptions& options);

}  // namespace slipstack::workbench
