// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "firmware/update/boot_choice.h"
#include "hal/host/program_memory.h"
#include "workbench/can/host_node/simulated_drive.h"

namespace slipstack::workbench {

/// As a new board comes: a program in slot 1, install number 1, confirmed.
inline void flash_new_board(host::HostProgramMemory& memory) {
  constexpr std::uint32_t kInstall = 1;
  std::array<std::byte, 256> program;
  program.fill(std::byte{0x5A});
  update::ImageHeader header;
  header.board = host::HostProgramMemory::kBoardId;
  header.version = update::kRevision;
  header.address = memory.address(0);
  header.size = static_cast<std::uint32_t>(program.size());
  header.crc = crc32(program);
  static_cast<void>(memory.slots[0].write(0, 0, update::to_bytes(header)));
  static_cast<void>(memory.slots[0].write(0, update::kInstallOffset, update::Mark::to_bytes(kInstall)));
  static_cast<void>(memory.slots[0].write(0, update::kHeaderBlock, program));
  static_cast<void>(update::TrialNotes(memory.notes(0)).add(update::TrialNotes::Note::kConfirmed, kInstall));
}

/// A simulated drive with two program slots and the boot loader between them. Whatever the slot holds, what
/// runs is the firmware of this build; but a program that begins with `crash` does not come up, and the
/// watchdog restarts the board.
class UpdatableDrive {
 public:
  using Make = std::function<std::unique_ptr<SimulatedDrive>(ProgramMemory&)>;
  static constexpr std::string_view kCrash = "crash";

  explicit UpdatableDrive(Make make) : make_(std::move(make)) {
    flash_new_board(memory_);
    boot();
  }

  /// One tick.
  void step() {
    if (drive_ == nullptr) {
      if (++ticks_down_ >= kWatchdog_ticks) boot();
      return;
    }
    drive_->step();
    if (memory_.restarted) boot();
  }

  host::HostProgramMemory& memory() { return memory_; }
  /// nullptr while it is down.
  SimulatedDrive* drive() { return drive_.get(); }

 private:
  static constexpr int kWatchdog_ticks = 20'000;  // 2 s: the boot loader's

  void boot() {
    memory_.restarted = false;
    drive_.reset();
    ticks_down_ = 0;
    const std::optional<std::size_t> slot = update::decide(memory_);
    if (!slot) return;
    memory_.runs = *slot;
    if (!crashes(*slot)) drive_ = make_(memory_);
  }
  bool crashes(std::size_t slot) const {
    std::array<std::byte, kCrash.size()> first;
    static_cast<void>(memory_.program(slot).read(0, update::kHeaderBlock, first));
    const std::span<const std::byte> crash = std::as_bytes(std::span(kCrash));
    return std::equal(first.begin(), first.end(), crash.begin());
  }

  host::HostProgramMemory memory_;
  Make make_;
  std::unique_ptr<SimulatedDrive> drive_;
  int ticks_down_ = 0;
};

}  // namespace slipstack::workbench
