// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/supervision/command_box.h"
#include "firmware/control/supervision/state_machine.h"

namespace slipstack {

/// The command of the main loop, and its time-out: in the tick, so that the axis stops even if the main loop
/// stands still.
class SupervisedCommand {
 public:
  // ---- outside the tick ----

  void write(const Command& command) { box_.write(command); }
  /// The control word alone, with what follows it or without; the rest stays.
  void write_word(std::uint32_t word) {
    const Command& now = read();
    write(Command{word, now.target_N, now.offset_N});
  }
  void write_control_word(std::uint16_t word) { write_word((read().word & 0xFFFF0000U) | word); }
  /// A command of the master came in this tick; those that supervision waits for are younger than
  /// `timeout_ticks`.
  void received(std::uint32_t tick, std::uint32_t timeout_ticks) {
    timeout_.store(timeout_ticks, std::memory_order_relaxed);
    received_at_.store(tick, std::memory_order_relaxed);
    lost_.store(false, std::memory_order_release);
  }
  /// The time ran out, and no command came since.
  bool lost() const { return lost_.load(std::memory_order_acquire); }

  // ---- in the tick ----

  const Command& read() const { return box_.read(); }
  /// The control word and what follows it, without the bits that a lost master takes back (kReactionShift).
  std::uint32_t word(std::uint32_t tick) {
    const std::uint32_t word = read().word;
    const std::uint32_t reaction = (word & (kLostDisables | kLostStops)) >> kReactionShift;
    const std::uint32_t age = tick - received_at_.load(std::memory_order_relaxed);
    if (reaction == 0 || age <= timeout_.load(std::memory_order_relaxed)) return word;
    lost_.store(true, std::memory_order_relaxed);
    return word & ~reaction;
  }

 private:
  CommandBox box_;
  std::atomic<std::uint32_t> received_at_{0};  // the tick of the last command
  std::atomic<std::uint32_t> timeout_{0};
  std::atomic<bool> lost_{false};
};

}  // namespace slipstack
