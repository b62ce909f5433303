// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <vector>

#include "hal/include/nonvolatile.h"

namespace slipstack::test {

using Bytes = std::vector<std::byte>;

/// Flash with a supply that fails at a given step: a step is one unit written, or one page erased. The unit
/// or page of that step then holds what `tear` says; everything later fails.
class CutFlash final : public Nonvolatile {
 public:
  enum class Tear { nothing, garbage, half, all };

  CutFlash(std::size_t pages, std::size_t page, std::size_t unit)
      : page_(page), unit_(unit), bytes(pages * page, std::byte{0xFF}), erased(pages, 0) {}
  std::size_t page_count() const override { return bytes.size() / page_; }
  std::size_t page_size() const override { return page_; }
  std::size_t write_unit() const override { return unit_; }
  NonvolatileStatus read(std::size_t page, std::size_t offset, std::span<std::byte> out) const override {
    if (page >= page_count() || offset + out.size() > page_) return NonvolatileStatus::kOutOfRange;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::size_t at = page * page_ + offset + i;
      // A torn unit of a flash with error correction cannot be read at all.
      if (unreadable.count(at / unit_) != 0) return NonvolatileStatus::kDeviceError;
      out[i] = bytes[at];
    }
    return NonvolatileStatus::kOk;
  }
  NonvolatileStatus write(std::size_t page, std::size_t offset, std::span<const std::byte> data) override {
    if (page >= page_count() || offset + data.size() > page_) return NonvolatileStatus::kOutOfRange;
    if (offset % unit_ != 0 || data.size() % unit_ != 0) return NonvolatileStatus::kMisaligned;
    for (std::size_t done = 0; done < data.size(); done += unit_) {
      const std::size_t at = page * page_ + offset + done;
      for (std::size_t i = 0; i < unit_; ++i) {
        if (bytes[at + i] != std::byte{0xFF}) return NonvolatileStatus::kNotErased;
      }
      if (!step(at, unit_, data.subspan(done, unit_))) return NonvolatileStatus::kDeviceError;
    }
    return NonvolatileStatus::kOk;
  }
  NonvolatileStatus erase(std::size_t page) override {
    if (page >= page_count()) return NonvolatileStatus::kOutOfRange;
    const Bytes blank(page_, std::byte{0xFF});
    for (std::size_t i = 0; i < page_ / unit_; ++i) unreadable.erase(page * page_ / unit_ + i);
    if (!step(page * page_, page_, blank)) return NonvolatileStatus::kDeviceError;
    ++erased[page];
    return NonvolatileStatus::kOk;
  }

  std::size_t steps = 0;
  std::optional<std::size_t> cut_at;
  Tear tear = Tear::nothing;
  bool torn_unreadable = false;
  std::mt19937 random{7};

 private:
  bool step(std::size_t at, std::size_t size, std::span<const std::byte> to) {
    if (cut_at && steps > *cut_at) return false;
    const bool cut = cut_at && steps == *cut_at;
    ++steps;
    for (std::size_t i = 0; i < size; ++i) {
      if (!cut || tear == Tear::all || (tear == Tear::half && i < size / 2)) bytes[at + i] = to[i];
      if (cut && tear == Tear::garbage) bytes[at + i] = static_cast<std::byte>(random() & 0xFFU);
    }
    if (cut && torn_unreadable) {
      for (std::size_t i = 0; i < size / unit_; ++i) unreadable.insert(at / unit_ + i);
    }
    return !cut;
  }
  std::size_t page_;
  std::size_t unit_;

 public:
  Bytes bytes;
  std::set<std::size_t> unreadable;
  std::vector<int> erased;
};

}  // namespace slipstack::test
