// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/alternatives/structure.h"

namespace slipstack::workbench {

/// A description of the pulses of the force that are impacts of the drive (Repairs::impacts), if there are
/// any: they last a few samples, so that below the band of the rows little may be left of them.
std::optional<Structure> impacts_in_drive(const Measurement& measurement);

}  // namespace slipstack::workbench
