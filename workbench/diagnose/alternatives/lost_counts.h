// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "workbench/diagnose/alternatives/structure.h"

namespace slipstack::workbench {

/// What the encoder's jumps (encoder_jumps()) say, where there are any. No effect of an axis makes them: a
/// model may be all that such a log needs once they are taken back, but the log is not all right.
std::optional<Structure> lost_counts(const Measurement& measurement);

}  // namespace slipstack::workbench
