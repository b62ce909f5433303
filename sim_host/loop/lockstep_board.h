// SPDX-License-Identifier: Apache-2.0
// A controller in lock-step with a plant, wherever it runs.
#pragma once

#include <stdexcept>

#include "hal/plant_link/plant_link.h"

namespace slipstack::sim {

/// A run that could not be continued; what() is one line with the reason.
struct LoopError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The host's end of a PlantLink.
class LockstepBoard {
 public:
  virtual ~LockstepBoard() = default;
  virtual PlantLink& link() = 0;
  /// Lets the controller run one tick with the words written before. Throws LoopError when it does not
  /// answer.
  virtual void tick() = 0;
};

}  // namespace slipstack::sim
