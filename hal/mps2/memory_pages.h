// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>

#include "hal/include/nonvolatile.h"

namespace slipstack::mps2 {

/// Pages of flash emulated in memory that outlives the firmware, with the rules of flash.
class MemoryFlashPages : public Nonvolatile {
 public:
  static constexpr std::size_t kUnit = 8;

  MemoryFlashPages(std::byte* memory, std::size_t pages, std::size_t page_bytes)
      : memory_(memory), pages_(pages), page_bytes_(page_bytes) {}

  std::size_t page_count() const override { return pages_; }
  std::size_t page_size() const override { return page_bytes_; }
  std::size_t write_unit() const override { return kUnit; }

  NonvolatileStatus read(std::size_t page, std::size_t offset, std::span<std::byte> out) const override {
    if (!inside(page, offset, out.size())) return NonvolatileStatus::kOutOfRange;
    std::copy_n(at(page, offset), out.size(), out.begin());
    return NonvolatileStatus::kOk;
  }
  NonvolatileStatus write(std::size_t page, std::size_t offset, std::span<const std::byte> data) override {
    const NonvolatileStatus status = writable(page, offset, data.size());
    if (status == NonvolatileStatus::kOk) std::copy(data.begin(), data.end(), at(page, offset));
    return status;
  }
  NonvolatileStatus erase(std::size_t page) override {
    if (page >= pages_) return NonvolatileStatus::kOutOfRange;
    std::memset(at(page, 0), 0xFF, page_bytes_);
    return NonvolatileStatus::kOk;
  }

 protected:
  /// Whether so many bytes can be written there.
  NonvolatileStatus writable(std::size_t page, std::size_t offset, std::size_t size) const {
    if (!inside(page, offset, size)) return NonvolatileStatus::kOutOfRange;
    if (offset % kUnit != 0 || size % kUnit != 0) return NonvolatileStatus::kMisaligned;
    const std::byte* const to = at(page, offset);
    const bool erased = std::all_of(to, to + size, [](std::byte b) { return b == std::byte{0xFF}; });
    return erased ? NonvolatileStatus::kOk : NonvolatileStatus::kNotErased;
  }
  std::byte* at(std::size_t page, std::size_t offset) const { return memory_ + page * page_bytes_ + offset; }

 private:
  bool inside(std::size_t page, std::size_t offset, std::size_t size) const {
    return page < pages_ && offset <= page_bytes_ && size <= page_bytes_ - offset;
  }

  std::byte* memory_;
  std::size_t pages_;
  std::size_t page_bytes_;
};

}  // namespace slipstack::mps2
