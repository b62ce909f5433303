// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "firmware/update/boot_choice.h"

namespace slipstack::update {

/// Why an update was refused, or came to an end.
enum class UpdateFault : std::uint8_t {
  kNone,
  kNotCleared,   ///< the slot was not cleared before
  kFormat,       ///< not an update file
  kWrongDevice,  ///< an image for another vendor, product or board
  kNotForSlot,   ///< all of it arrived, and no image in it is linked for the spare slot
  kTooLarge,     ///< the program does not fit the slot
  kCutShort,     ///< the transfer ended before the image did
  kChecksum,     ///< the program in flash is not the one that the header names
  kFlash,        ///< the flash refused, or reads back differently
  kOnTrial,      ///< the running program has not reported in: the other one is what it falls back to
  kNoProgram,    ///< nothing has been loaded that could be started
};

/// Writes an image into the spare slot. The running one is never touched, and nothing in the slot can be
/// started before install(): the header is the first that is erased and the last that is written.
///
/// An update file is one image after the other, each its header and its program; the one for the spare slot
/// is taken, the others are passed over. What arrives may begin with a header of kContinue: the transfer goes
/// on where the one before broke off.
class ProgramWriter {
 public:
  explicit ProgramWriter(ProgramMemory& memory) : memory_(memory) {}

  std::size_t slot() const { return memory_.running() ^ 1U; }
  bool clearing() const { return phase_ == Phase::kClearing; }
  /// Bytes of the program taken so far, and its CRC-32: where a transfer may go on, and of what.
  std::uint32_t taken() const { return taken_; }
  std::uint32_t crc() const { return header_.crc; }

  /// Begins to erase the slot; step() goes on.
  UpdateFault clear() {
    phase_ = Phase::kEmpty;
    taken_ = 0;
    header_ = {};
    if (look_at_running(memory_).state == SlotState::kTrial) return UpdateFault::kOnTrial;
    page_ = 0;
    phase_ = Phase::kClearing;
    return UpdateFault::kNone;
  }
  /// One page, the first one first: about 22 ms on a part, less where it is blank.
  UpdateFault step() {
    if (phase_ != Phase::kClearing) return UpdateFault::kNone;
    Nonvolatile& pages = memory_.spare();
    if (!blank(page_) && pages.erase(page_) != NonvolatileStatus::kOk) {
      phase_ = Phase::kEmpty;
      return UpdateFault::kFlash;
    }
    if (++page_ == pages.page_count()) phase_ = Phase::kCleared;
    return UpdateFault::kNone;
  }

  /// A transfer begins.
  UpdateFault begin() {
    if (phase_ != Phase::kCleared && phase_ != Phase::kReceiving) return UpdateFault::kNotCleared;
    head_filled_ = 0;
    skip_ = 0;
    in_program_ = false;
    return UpdateFault::kNone;
  }

  /// The next bytes of the transfer.
  UpdateFault write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      std::size_t used = 0;
      UpdateFault fault = UpdateFault::kNone;
      if (skip_ > 0) {
        used = std::min<std::size_t>(skip_, bytes.size());
        skip_ -= static_cast<std::uint32_t>(used);
      } else if (in_program_) {
        used = std::min<std::size_t>({bytes.size(), header_.size - taken_, part_.size() - part_filled_});
        fault = take(bytes.first(used));
      } else {
        used = std::min(bytes.size(), head_.size() - head_filled_);
        std::copy_n(bytes.begin(), used, head_.begin() + static_cast<std::ptrdiff_t>(head_filled_));
        head_filled_ += used;
        if (head_filled_ == head_.size()) fault = take_header();
      }
      if (fault != UpdateFault::kNone) return fault;
      bytes = bytes.subspan(used);
    }
    return UpdateFault::kNone;
  }

  /// The transfer is complete: the program is read back against its CRC, then its header is written.
  UpdateFault finish() {
    if (phase_ != Phase::kReceiving)
      return head_filled_ > 0 ? UpdateFault::kCutShort : UpdateFault::kNotForSlot;
    if (taken_ != header_.size || skip_ > 0 || head_filled_ > 0) return UpdateFault::kCutShort;
    phase_ = Phase::kEmpty;
    if (!intact(memory_, slot(), header_)) return UpdateFault::kChecksum;
    if (memory_.spare().write(0, 0, to_bytes(header_)) != NonvolatileStatus::kOk) return UpdateFault::kFlash;
    phase_ = Phase::kLoaded;
    return UpdateFault::kNone;
  }

  /// From the next restart on the new image is started, on trial.
  UpdateFault install() {
    if (phase_ != Phase::kLoaded) return UpdateFault::kNoProgram;
    const std::uint32_t number = next_install();
    phase_ = Phase::kEmpty;
    const bool written =
        memory_.spare().write(0, kInstallOffset, Mark::to_bytes(number)) == NonvolatileStatus::kOk;
    return written ? UpdateFault::kNone : UpdateFault::kFlash;
  }

 private:
  enum class Phase : std::uint8_t { kEmpty, kClearing, kCleared, kReceiving, kLoaded };

  bool blank(std::size_t page) const {
    const Nonvolatile& pages = memory_.program(slot());
    for (std::size_t at = 0; at < pages.page_size(); at += Mark::kBytes) {
      if (!Mark::blank(pages, page, at)) return false;
    }
    return true;
  }

  // Each header says how many bytes follow it.
  UpdateFault take_header() {
    head_filled_ = 0;
    ImageHeader header;
    if (!from_bytes(head_, header)) return UpdateFault::kFormat;
    if (!is_for(header, memory_.board())) return UpdateFault::kWrongDevice;
    if (header.magic == ImageHeader::kContinue) return go_on(header);
    if (header.address != memory_.address(slot())) {
      skip_ = header.size;
      return UpdateFault::kNone;
    }
    if (header.size == 0) return UpdateFault::kFormat;
    if (header.size > program_capacity(memory_.program(slot()))) return UpdateFault::kTooLarge;
    // What was taken of another transfer lies in the flash already.
    if (phase_ != Phase::kCleared) return UpdateFault::kNotCleared;
    header_ = header;
    taken_ = 0;
    part_filled_ = 0;
    phase_ = Phase::kReceiving;
    in_program_ = true;
    return UpdateFault::kNone;
  }
  UpdateFault go_on(const ImageHeader& header) {
    const bool same = phase_ == Phase::kReceiving && header.crc == header_.crc &&
                      header.size == header_.size && header.address == header_.address &&
                      header.offset == taken_;
    if (!same) return UpdateFault::kNotCleared;
    in_program_ = taken_ < header_.size;
    return UpdateFault::kNone;
  }

  // Into a part, and a full part into the flash; the last one filled up with FFh.
  UpdateFault take(std::span<const std::byte> bytes) {
    std::copy(bytes.begin(), bytes.end(), part_.begin() + static_cast<std::ptrdiff_t>(part_filled_));
    part_filled_ += bytes.size();
    taken_ += static_cast<std::uint32_t>(bytes.size());
    in_program_ = taken_ < header_.size;
    if (part_filled_ < part_.size() && in_program_) return UpdateFault::kNone;
    std::fill(part_.begin() + static_cast<std::ptrdiff_t>(part_filled_), part_.end(), std::byte{0xFF});
    const std::size_t at = kHeaderBlock + taken_ - part_filled_;
    part_filled_ = 0;
    Nonvolatile& pages = memory_.spare();
    const bool written =
        pages.write(at / pages.page_size(), at % pages.page_size(), part_) == NonvolatileStatus::kOk;
    if (!written) phase_ = Phase::kEmpty;
    return written ? UpdateFault::kNone : UpdateFault::kFlash;
  }

  std::uint32_t next_install() {
    std::uint32_t highest = 0;
    for (std::size_t slot = 0; slot < ProgramMemory::kSlots; ++slot) {
      highest = std::max({highest, look(memory_, slot).install, TrialNotes(memory_.notes(slot)).highest()});
    }
    return std::min(highest + 1, kInstallLargest);
  }

  ProgramMemory& memory_;
  Phase phase_ = Phase::kEmpty;
  std::size_t page_ = 0;
  ImageHeader header_;
  std::uint32_t taken_ = 0;
  std::uint32_t skip_ = 0;  // bytes of an image for the other slot
  bool in_program_ = false;
  HeaderBytes head_{};
  std::size_t head_filled_ = 0;
  std::array<std::byte, 64> part_{};
  std::size_t part_filled_ = 0;
};

}  // namespace slipstack::update
