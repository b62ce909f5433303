// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "hal/include/nonvolatile.h"

namespace slipstack::update {

/// A number with its complement: one write unit of flash, which is there whole or not at all.
struct Mark {
  static constexpr std::size_t kBytes = 8;

  static std::array<std::byte, kBytes> to_bytes(std::uint32_t word) {
    const std::array<std::uint32_t, 2> words = {word, ~word};
    std::array<std::byte, kBytes> bytes;
    std::memcpy(bytes.data(), words.data(), kBytes);
    return bytes;
  }
  /// The word at this place; 0 where there is none, or where power failed while it was written.
  static std::uint32_t read(const Nonvolatile& pages, std::size_t page, std::size_t offset) {
    std::array<std::byte, kBytes> bytes;
    if (pages.read(page, offset, bytes) != NonvolatileStatus::kOk) return 0;
    std::array<std::uint32_t, 2> words;
    std::memcpy(words.data(), bytes.data(), kBytes);
    return words[0] == ~words[1] ? words[0] : 0;
  }
  static bool blank(const Nonvolatile& pages, std::size_t page, std::size_t offset) {
    std::array<std::byte, kBytes> bytes;
    return pages.read(page, offset, bytes) == NonvolatileStatus::kOk &&
           std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0xFF}; });
  }
};

/// Each install has a number, one more than all before. 24 bits: ten a day for 4 000 years.
inline constexpr std::uint32_t kInstallLargest = 0xFFFFFF;

/// One page of notes about a slot, appended one write unit each: that the image of this install was started
/// on trial, and that it reported in. Notes of earlier installs have no meaning any more.
class TrialNotes {
 public:
  enum class Note : std::uint32_t { kStarted = 0x53, kConfirmed = 0x43 };  // 'S', 'C'
  /// What one install needs at most, a unit for a start that power cut included each time.
  static constexpr std::size_t kRoom = 16;

  explicit TrialNotes(Nonvolatile& page) : page_(page) {}

  /// How often this note stands here for this install.
  std::uint32_t count(Note note, std::uint32_t install) const {
    std::uint32_t found = 0;
    for (std::size_t i = 0; i < units(); ++i)
      found += Mark::read(page_, 0, i * Mark::kBytes) == word(note, install);
    return found;
  }
  bool confirmed(std::uint32_t install) const { return count(Note::kConfirmed, install) > 0; }
  std::uint32_t starts(std::uint32_t install) const { return count(Note::kStarted, install); }

  /// The highest number of an install that is noted; 0 if there is none.
  std::uint32_t highest() const {
    std::uint32_t found = 0;
    for (std::size_t i = 0; i < units(); ++i) {
      const std::uint32_t word = Mark::read(page_, 0, i * Mark::kBytes);
      const std::uint32_t note = word >> 24U;
      const bool known = note == static_cast<std::uint32_t>(Note::kStarted) ||
                         note == static_cast<std::uint32_t>(Note::kConfirmed);
      if (known) found = std::max(found, word & kInstallLargest);
    }
    return found;
  }

  /// Appends a note. False: the page is full, or the device refused.
  bool add(Note note, std::uint32_t install) {
    const std::size_t at = end();
    if (at >= units()) return false;
    return page_.write(0, at * Mark::kBytes, Mark::to_bytes(word(note, install))) == NonvolatileStatus::kOk;
  }

  /// For an install without a note: erases the page where it is too full for the notes to come.
  bool make_room() { return units() - end() >= kRoom || page_.erase(0) == NonvolatileStatus::kOk; }

 private:
  static std::uint32_t word(Note note, std::uint32_t install) {
    return (static_cast<std::uint32_t>(note) << 24U) | (install & kInstallLargest);
  }
  std::size_t units() const { return page_.page_size() / Mark::kBytes; }
  // Behind the last unit that holds anything, be it half a note.
  std::size_t end() const {
    std::size_t at = units();
    while (at > 0 && Mark::blank(page_, 0, (at - 1) * Mark::kBytes)) --at;
    return at;
  }

  Nonvolatile& page_;
};

}  // namespace slipstack::update
