// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/update/image_header.h"
#include "firmware/update/trial_notes.h"
#include "hal/include/program_memory.h"

// Which of two slots is started. The same functions in the boot loader, in the running program, which tells
// the bus, and in tests.
namespace slipstack::update {

/// A new image is started so often before it is given up: a supply that fails twice while it starts does not
/// condemn it.
inline constexpr std::uint32_t kTrialStarts = 3;

/// Where the number of the install stands in the header block: behind the header.
inline constexpr std::size_t kInstallOffset = kHeaderBytes;

enum class SlotState : std::uint8_t {
  kEmpty,      ///< no image, or none that was told to start
  kTrial,      ///< installed, has not reported in yet
  kConfirmed,  ///< has reported in
  kGivenUp,    ///< was started kTrialStarts times and has not
};

struct SlotView {
  ImageHeader header;
  std::uint32_t install = 0;
  std::uint32_t starts = 0;  ///< noted of this install
  SlotState state = SlotState::kEmpty;
};

/// What fits a slot behind the header block.
inline std::size_t program_capacity(const Nonvolatile& pages) {
  return pages.page_count() * pages.page_size() - kHeaderBlock;
}

/// The header of a slot. False: there is none for this board and this slot.
inline bool read_header(const ProgramMemory& memory, std::size_t slot, ImageHeader& header) {
  const Nonvolatile& pages = memory.program(slot);
  HeaderBytes bytes;
  if (pages.read(0, 0, bytes) != NonvolatileStatus::kOk) return false;
  return from_bytes(bytes, header) && header.magic == ImageHeader::kMagic && is_for(header, memory.board()) &&
         header.address == memory.address(slot) && header.size > 0 && header.size <= program_capacity(pages);
}

/// What is known of a slot without reading its program.
inline SlotView look(ProgramMemory& memory, std::size_t slot) {
  SlotView view;
  if (!read_header(memory, slot, view.header)) return {};
  view.install = Mark::read(memory.program(slot), 0, kInstallOffset);
  if (view.install == 0 || view.install > kInstallLargest) return {};
  const TrialNotes notes(memory.notes(slot));
  if (notes.confirmed(view.install)) {
    view.state = SlotState::kConfirmed;
  } else {
    view.starts = notes.starts(view.install);
    view.state = view.starts < kTrialStarts ? SlotState::kTrial : SlotState::kGivenUp;
  }
  return view;
}

/// The running program as it sees itself: its own start is noted already, so the third one is a trial still.
inline SlotView look_at_running(ProgramMemory& memory) {
  SlotView view = look(memory, memory.running());
  if (view.state == SlotState::kGivenUp && view.starts == kTrialStarts) view.state = SlotState::kTrial;
  return view;
}

/// Whether the program of a slot is, byte for byte, the one that its header names. Reads all of it: outside
/// the tick only.
inline bool intact(const ProgramMemory& memory, std::size_t slot, const ImageHeader& header) {
  const Nonvolatile& pages = memory.program(slot);
  if (header.size > program_capacity(pages)) return false;
  std::array<std::byte, 64> part;
  std::uint32_t crc = 0;
  for (std::size_t done = 0; done < header.size; done += part.size()) {
    const std::size_t at = kHeaderBlock + done;
    const auto bytes = std::span(part).first(std::min<std::size_t>(part.size(), header.size - done));
    if (pages.read(at / pages.page_size(), at % pages.page_size(), bytes) != NonvolatileStatus::kOk)
      return false;
    crc = crc32(bytes, crc);
  }
  return crc == header.crc;
}

/// The slots in the order in which they are tried: those not given up first, of these the latest install.
inline std::array<std::size_t, 2> order_of(const std::array<SlotView, 2>& slots) {
  const auto before = [](const SlotView& one, const SlotView& other) {
    const bool one_failed = one.state == SlotState::kGivenUp;
    const bool other_failed = other.state == SlotState::kGivenUp;
    return one_failed != other_failed ? other_failed : one.install > other.install;
  };
  return before(slots[1], slots[0]) ? std::array<std::size_t, 2>{1, 0} : std::array<std::size_t, 2>{0, 1};
}

/// The slot to be started: the first in that order whose program is whole. An image that was given up is
/// started when there is no other: better than none.
template <class Whole>
std::optional<std::size_t> choose(const std::array<SlotView, 2>& slots, Whole&& whole) {
  for (const std::size_t slot : order_of(slots)) {
    if (slots[slot].state != SlotState::kEmpty && whole(slot)) return slot;
  }
  return std::nullopt;
}

/// What the boot loader does at every start: chooses a slot, and notes the start of an image on trial before
/// it is started. An image whose start cannot be noted would be on trial for ever: it counts as given up. One
/// more start than the trial has tells the program that it was started for want of another.
inline std::optional<std::size_t> decide(ProgramMemory& memory) {
  std::array<SlotView, 2> slots = {look(memory, 0), look(memory, 1)};
  const auto whole = [&](std::size_t slot) { return intact(memory, slot, slots[slot].header); };
  const std::optional<std::size_t> chosen = choose(slots, whole);
  if (!chosen || slots[*chosen].state == SlotState::kConfirmed) return chosen;
  SlotView& view = slots[*chosen];
  if (view.starts > kTrialStarts) return chosen;
  TrialNotes notes(memory.notes(*chosen));
  const bool room = view.starts > 0 || notes.make_room();
  const bool noted = room && notes.add(TrialNotes::Note::kStarted, view.install);
  if (noted || view.state == SlotState::kGivenUp) return chosen;
  view.state = SlotState::kGivenUp;
  return choose(slots, whole);
}

}  // namespace slipstack::update
