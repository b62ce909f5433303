// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace slipstack {

/// What the main loop demands of the tick; all of it acts from the same tick on.
struct Command {
  std::uint32_t word = 0;  ///< control word, kTorqueMode and what follows it
  float target_N = 0.0F;   ///< force in torque mode
  float offset_N = 0.0F;   ///< force added in every mode
};

/// Passes commands to the tick, which interrupts the main loop wherever it is: a command is written into the
/// place that the tick does not read, and the places are exchanged by one store.
class CommandBox {
 public:
  /// Outside the tick.
  void write(const Command& command) {
    const std::uint32_t spare = newest_.load(std::memory_order_relaxed) ^ 1U;
    commands_[spare] = command;
    newest_.store(spare, std::memory_order_release);
  }
  /// The newest command; in the tick and outside it.
  const Command& read() const { return commands_[newest_.load(std::memory_order_acquire)]; }

 private:
  std::array<Command, 2> commands_{};
  std::atomic<std::uint32_t> newest_{0};
};

}  // namespace slipstack
