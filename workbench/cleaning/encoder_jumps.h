// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/log/log.h"

namespace slipstack::workbench {

/// From sample `sample` on the encoder reads `jump_m` too much.
struct EncoderJump {
  std::size_t sample = 0;
  double jump_m = 0.0;
};

/// Finds where the position jumps between two samples and the motion then continues as before: the forces in
/// the log cannot move the mass that far in one sample, so the encoder has lost or gained counts. Ascending;
/// empty where there are so many that they belong to the way the position is recorded. A jump after a
/// standstill during which the force shows motion is not counted: there the encoder was stuck, and reads
/// correctly again. O(n).
std::vector<EncoderJump> encoder_jumps(const Log& log);

/// Subtracts the jumps from the positions after them.
void remove_jumps(const std::vector<EncoderJump>& jumps, Log& log);

}  // namespace slipstack::workbench
