// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>

namespace slipstack {

/// Resets the board unless refreshed. The control tick refreshes it, while the main loop advances too, and
/// nothing else does: when either stops, the board restarts with zero current.
template <class W>
concept Watchdog = requires(W watchdog) {
  {watchdog.refresh()};
  { watchdog.caused_last_reset() } -> std::same_as<bool>;
};

}  // namespace slipstack
