// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/host/board.h"
#include "hal/include/program_memory.h"

namespace slipstack::host {

/// Two slots in memory, of the size that the NUCLEO-G474RE has. Whoever owns the board looks at `restarted`
/// and starts it anew.
class HostProgramMemory final : public ProgramMemory {
 public:
  static constexpr std::uint32_t kBoardId = 0x54534F48;  // "HOST"
  static constexpr std::size_t kPages = 112;
  static constexpr std::size_t kPageBytes = 2048;
  static constexpr std::array<std::uint32_t, 2> kAddresses = {0x08007000, 0x08047000};

  std::size_t running() const override { return runs; }
  std::uint32_t board() const override { return kBoardId; }
  std::uint32_t address(std::size_t slot) const override { return kAddresses[slot]; }
  const Nonvolatile& program(std::size_t slot) const override { return slots[slot]; }
  Nonvolatile& spare() override { return slots[runs ^ 1U]; }
  Nonvolatile& notes(std::size_t slot) override { return pages_of_notes[slot]; }
  void restart() override { restarted = true; }

  std::size_t runs = 0;
  bool restarted = false;
  std::array<HostNonvolatile, 2> slots{HostNonvolatile{kPages, kPageBytes, 8},
                                       HostNonvolatile{kPages, kPageBytes, 8}};
  std::array<HostNonvolatile, 2> pages_of_notes{HostNonvolatile{1, kPageBytes, 8},
                                                HostNonvolatile{1, kPageBytes, 8}};
};

}  // namespace slipstack::host
