// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/exchange_box.h"

namespace slipstack {

/// What the main loop demands of the tick; all of it acts from the same tick on.
struct Command {
  std::uint32_t word = 0;  ///< control word, kTorqueMode and what follows it
  float target_N = 0.0F;   ///< force in torque mode
  float offset_N = 0.0F;   ///< force added in every mode
};
using CommandBox = ExchangeBox<Command>;

}  // namespace slipstack
