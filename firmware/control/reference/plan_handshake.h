// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/reference/reference.h"

namespace slipstack {

/// Whether the tick took over the last plan of the main loop. It does not where it was gone past the plan
/// before that was ready: the motion is then asked for again.
class PlanHandshake {
 public:
  enum class State : std::uint8_t { kWaits, kTaken, kMissed };

  /// Before a plan is made.
  void begin(const ReferenceGenerator& reference) { plans_before_ = reference.plans_taken(); }
  State of(const ReferenceGenerator& reference) const {
    if (reference.plan_waits()) return State::kWaits;
    return reference.plans_taken() == plans_before_ ? State::kMissed : State::kTaken;
  }

 private:
  std::uint32_t plans_before_ = 0;
};

}  // namespace slipstack
