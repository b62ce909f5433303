// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstring>

#include "hal/mps2/memory_pages.h"
#include "hal/plant_link/plant_link.h"

namespace slipstack::mps2 {

/// Flash emulated in memory that outlives the firmware: as many pages, of the same size and write unit, as
/// the NUCLEO-G474RE has for parameters. The host may look at it, fill it, and start the next run with it.
class MemoryFlash final : public MemoryFlashPages {
 public:
  static constexpr std::size_t kPages = PlantMemory::kFlashPages;
  static constexpr std::size_t kPageBytes = PlantMemory::kFlashPageBytes;

  /// `memory`: a formatted marker of 8 bytes, then the pages.
  explicit MemoryFlash(std::byte* memory)
      : MemoryFlashPages(memory + kMarker.size(), kPages, kPageBytes), marker_(memory) {}

  /// Erases everything the first time that this memory is seen.
  void start() {
    if (std::memcmp(marker_, kMarker.data(), kMarker.size()) == 0) return;
    std::memset(at(0, 0), 0xFF, kPages * kPageBytes);
    std::memcpy(marker_, kMarker.data(), kMarker.size());
  }

 private:
  static constexpr std::array<char, 8> kMarker = {'s', 'l', 'i', 'p', 'n', 'v', '0', '1'};

  std::byte* marker_;
};

}  // namespace slipstack::mps2
