// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "workbench/log/log.h"

namespace slipstack::workbench {

/// From sample `sample` on the encoder reads `jump_m` more than it would have.
struct EncoderJump {
  std::size_t sample = 0;
  double jump_m = 0.0;
};

/// Where the position jumps between two samples and goes on as it went before: no mass can be put elsewhere
/// in that time by the forces that the log shows, so the encoder has lost or made up counts. Ascending; empty
/// where there are so many that they are how the position is recorded. One that comes after a standstill in
/// which the force says that the axis moved is no jump: the encoder was stuck, and is right again. O(n).
std::vector<EncoderJump> encoder_jumps(const Log& log);

/// Takes them back: all positions are then counted as before the first.
void take_back(const std::vector<EncoderJump>& jumps, Log& log);

}  // namespace slipstack::workbench
