// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/update/boot_choice.h"

namespace slipstack::update {

/// The running program on trial: confirms it once it has reported in, and restarts the board when it does
/// not, so that the boot loader counts and in the end goes back to the program before. Where a program
/// crashes instead, the watchdog does the same.
///
/// Flash is written while the power stage is off only, and the board is restarted then only: the time that
/// the axis is driven counts for neither.
class TrialWatch {
 public:
  static constexpr std::uint32_t kReport_us = 5'000'000;   ///< so long without a gap it must report
  static constexpr std::uint32_t kGiveUp_us = 60'000'000;  ///< so long it has for that

  explicit TrialWatch(ProgramMemory& memory)
      : memory_(memory),
        view_(look_at_running(memory)),
        open_(view_.state == SlotState::kTrial || view_.state == SlotState::kGivenUp) {}

  /// Once in every pass of the main loop. `reports`: the node is on the bus and others acknowledge what it
  /// sends. `idle`: the power stage is off.
  void step(std::uint32_t now_us, bool reports, bool idle) {
    const std::uint32_t passed_us = first_ ? 0 : now_us - last_us_;
    first_ = false;
    last_us_ = now_us;
    if (!open_ || !idle) return;
    waited_us_ += passed_us;
    reported_us_ = reports ? reported_us_ + passed_us : 0;
    if (reported_us_ >= kReport_us) return confirm();
    // One that was given up runs for want of another: a restart would help nobody, and it may still report.
    if (waited_us_ >= kGiveUp_us && view_.state == SlotState::kTrial) memory_.restart();
  }

  SlotState state() const { return view_.state; }

 private:
  // A note that the flash does not take is tried again after another report.
  void confirm() {
    reported_us_ = 0;
    TrialNotes notes(memory_.notes(memory_.running()));
    if (!notes.add(TrialNotes::Note::kConfirmed, view_.install)) return;
    view_.state = SlotState::kConfirmed;
    open_ = false;
  }

  ProgramMemory& memory_;
  SlotView view_;
  bool open_;
  bool first_ = true;
  std::uint32_t last_us_ = 0;
  std::uint32_t waited_us_ = 0;
  std::uint32_t reported_us_ = 0;
};

}  // namespace slipstack::update
