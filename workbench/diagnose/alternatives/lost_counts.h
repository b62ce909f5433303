// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/alternatives/structure.h"

namespace slipstack::workbench {

/// A description of the jumps of the encoder (encoder_jumps()), if there are any. They were removed from the
/// position, so that the model may be complete; but no axis causes them, and the user must know.
std::optional<Structure> lost_counts(const Measurement& measurement);

}  // namespace slipstack::workbench
