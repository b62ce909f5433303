// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "hal/include/nonvolatile.h"
#include "hal/plant_link/plant_link.h"

namespace slipstack::mps2 {

/// Flash emulated in memory that outlives the firmware: as many pages, of the same size and write unit, as
/// the NUCLEO-G474RE has for parameters. The host may look at it, fill it, and start the next run with it.
class MemoryFlash final : public Nonvolatile {
 public:
  static constexpr std::size_t kPages = PlantMemory::kFlashPages;
  static constexpr std::size_t kPageBytes = PlantMemory::kFlashPageBytes;
  static constexpr std::size_t kUnit = 8;

  /// `memory`: a formatted marker of 8 bytes, then the pages.
  explicit MemoryFlash(std::byte* memory) : memory_(memory) {}

  /// Erases everything the first time that this memory is seen.
  void start() {
    if (std::memcmp(memory_, kMarker.data(), kMarker.size()) == 0) return;
    std::memset(memory_ + kMarker.size(), 0xFF, kPages * kPageBytes);
    std::memcpy(memory_, kMarker.data(), kMarker.size());
  }

  std::size_t page_count() const override { return kPages; }
  std::size_t page_size() const override { return kPageBytes; }
  std::size_t write_unit() const override { return kUnit; }

  NonvolatileStatus read(std::size_t page, std::size_t offset, std::span<std::byte> out) const override {
    if (!inside(page, offset, out.size())) return NonvolatileStatus::kOutOfRange;
    std::copy_n(at(page, offset), out.size(), out.begin());
    return NonvolatileStatus::kOk;
  }
  NonvolatileStatus write(std::size_t page, std::size_t offset, std::span<const std::byte> data) override {
    if (!inside(page, offset, data.size())) return NonvolatileStatus::kOutOfRange;
    if (offset % kUnit != 0 || data.size() % kUnit != 0) return NonvolatileStatus::kMisaligned;
    std::byte* const to = at(page, offset);
    if (std::any_of(to, to + data.size(), [](std::byte b) { return b != std::byte{0xFF}; })) {
      return NonvolatileStatus::kNotErased;
    }
    std::copy(data.begin(), data.end(), to);
    return NonvolatileStatus::kOk;
  }
  NonvolatileStatus erase(std::size_t page) override {
    if (page >= kPages) return NonvolatileStatus::kOutOfRange;
    std::memset(at(page, 0), 0xFF, kPageBytes);
    return NonvolatileStatus::kOk;
  }

 private:
  static constexpr std::array<char, 8> kMarker = {'s', 'l', 'i', 'p', 'n', 'v', '0', '1'};

  static bool inside(std::size_t page, std::size_t offset, std::size_t size) {
    return page < kPages && offset <= kPageBytes && size <= kPageBytes - offset;
  }
  std::byte* at(std::size_t page, std::size_t offset) const {
    return memory_ + kMarker.size() + page * kPageBytes + offset;
  }

  std::byte* memory_;
};

}  // namespace slipstack::mps2
