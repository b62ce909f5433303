// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <vector>

#include "hal/include/program_memory.h"

// Program memory on a supply that fails at a given step, and images for it. Sizes, header and CRC are written
// here from docs/firmware-update.md: nothing of the firmware's own encoding is used.
namespace slipstack::test {

using Bytes = std::vector<std::byte>;

enum class Tear { kNothing, kGarbage, kHalf, kAll };

/// A step is one unit written, or one page erased. The unit or page of the step at which the supply fails
/// holds what `tear` says; every later step fails.
struct Supply {
  std::size_t steps = 0;
  std::optional<std::size_t> cut_at;
  Tear tear = Tear::kNothing;
  bool torn_unreadable = false;
  std::mt19937 random{7};

  bool dead() const { return cut_at && steps > *cut_at; }
  void restore() { cut_at.reset(); }
};

class CutPages final : public Nonvolatile {
 public:
  static constexpr std::size_t kUnit = 8;

  CutPages(Supply* supply, std::size_t pages, std::size_t page)
      : bytes(pages * page, std::byte{0xFF}), supply_(supply), page_(page) {}

  std::size_t page_count() const override { return bytes.size() / page_; }
  std::size_t page_size() const override { return page_; }
  std::size_t write_unit() const override { return kUnit; }
  NonvolatileStatus read(std::size_t page, std::size_t offset, std::span<std::byte> out) const override {
    if (page >= page_count() || offset + out.size() > page_) return NonvolatileStatus::kOutOfRange;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::size_t at = page * page_ + offset + i;
      if (unreadable.contains(at / kUnit)) return NonvolatileStatus::kDeviceError;
      out[i] = bytes[at];
    }
    return NonvolatileStatus::kOk;
  }
  NonvolatileStatus write(std::size_t page, std::size_t offset, std::span<const std::byte> data) override {
    if (page >= page_count() || offset + data.size() > page_) return NonvolatileStatus::kOutOfRange;
    if (offset % kUnit != 0 || data.size() % kUnit != 0) return NonvolatileStatus::kMisaligned;
    for (std::size_t done = 0; done < data.size(); done += kUnit) {
      const std::size_t at = page * page_ + offset + done;
      if (unreadable.contains(at / kUnit)) return NonvolatileStatus::kNotErased;
      for (std::size_t i = 0; i < kUnit; ++i) {
        if (bytes[at + i] != std::byte{0xFF}) return NonvolatileStatus::kNotErased;
      }
      if (!step(at, kUnit, data.subspan(done, kUnit))) return NonvolatileStatus::kDeviceError;
    }
    return NonvolatileStatus::kOk;
  }
  NonvolatileStatus erase(std::size_t page) override {
    if (page >= page_count()) return NonvolatileStatus::kOutOfRange;
    if (supply_->dead()) return NonvolatileStatus::kDeviceError;
    ++erasures;
    for (std::size_t i = 0; i < page_ / kUnit; ++i) unreadable.erase(page * page_ / kUnit + i);
    const Bytes blank(page_, std::byte{0xFF});
    return step(page * page_, page_, blank) ? NonvolatileStatus::kOk : NonvolatileStatus::kDeviceError;
  }

  Bytes bytes;
  std::set<std::size_t> unreadable;
  std::size_t erasures = 0;

 private:
  friend class CutMemory;

  bool step(std::size_t at, std::size_t size, std::span<const std::byte> to) {
    if (supply_->dead()) return false;
    const bool cut = supply_->cut_at && supply_->steps == *supply_->cut_at;
    ++supply_->steps;
    for (std::size_t i = 0; i < size; ++i) {
      const bool reached =
          !cut || supply_->tear == Tear::kAll || (supply_->tear == Tear::kHalf && i < size / 2);
      if (reached) bytes[at + i] = to[i];
      if (cut && supply_->tear == Tear::kGarbage)
        bytes[at + i] = static_cast<std::byte>(supply_->random() & 0xFFU);
    }
    if (cut && supply_->torn_unreadable) {
      for (std::size_t i = 0; i < size / kUnit; ++i) unreadable.insert(at / kUnit + i);
    }
    return !cut;
  }

  Supply* supply_;
  std::size_t page_;
};

class CutMemory final : public ProgramMemory {
 public:
  static constexpr std::uint32_t kBoard = 0x54534554;  // "TEST"
  static constexpr std::array<std::uint32_t, 2> kAddresses = {0x1000, 0x9000};

  explicit CutMemory(std::size_t pages = 8, std::size_t page = 512)
      : slots{CutPages(&supply, pages, page), CutPages(&supply, pages, page)},
        note_pages{CutPages(&supply, 1, page), CutPages(&supply, 1, page)} {}
  CutMemory(const CutMemory& other)
      : supply(other.supply), runs(other.runs), slots(other.slots), note_pages(other.note_pages) {
    for (auto* pages : {&slots, &note_pages}) {
      for (CutPages& one : *pages) one.supply_ = &supply;
    }
  }
  CutMemory& operator=(const CutMemory&) = delete;
  ~CutMemory() = default;

  std::size_t running() const override { return runs; }
  std::uint32_t board() const override { return kBoard; }
  std::uint32_t address(std::size_t slot) const override { return kAddresses[slot]; }
  const Nonvolatile& program(std::size_t slot) const override { return slots[slot]; }
  Nonvolatile& spare() override { return slots[runs ^ 1U]; }
  Nonvolatile& notes(std::size_t slot) override { return note_pages[slot]; }
  void restart() override { ++restarts; }

  Supply supply;
  std::size_t runs = 0;
  int restarts = 0;
  std::array<CutPages, 2> slots;
  std::array<CutPages, 2> note_pages;
};

/// CRC-32 by division of the message, bit by bit, as IEEE 802.3 3.2.9 has it: the first 32 bits complemented,
/// each byte least significant bit first, the remainder complemented and reflected.
inline std::uint32_t crc_by_division(std::span<const std::byte> bytes) {
  std::uint32_t rest = 0xFFFFFFFF;
  for (const std::byte byte : bytes) {
    for (int bit = 0; bit < 8; ++bit) {
      const std::uint32_t next = std::to_integer<std::uint32_t>(byte) >> bit & 1U;
      const bool subtract = (rest >> 31U ^ next) != 0;
      rest = rest << 1U ^ (subtract ? 0x04C11DB7U : 0U);
    }
  }
  std::uint32_t reflected = 0;
  for (int bit = 0; bit < 32; ++bit) reflected |= (rest >> bit & 1U) << (31 - bit);
  return ~reflected;
}

inline Bytes words(const std::vector<std::uint32_t>& list) {
  Bytes bytes;
  for (const std::uint32_t word : list) {
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::byte>(word >> (8 * i) & 0xFFU));
  }
  return bytes;
}

inline Bytes joined(const Bytes& first, const Bytes& second) {
  Bytes both;
  both.reserve(first.size() + second.size());
  for (const Bytes* part : {&first, &second}) {
    for (const std::byte byte : *part) both.push_back(byte);
  }
  return both;
}

struct HeaderWords {
  std::uint32_t magic = 0x49504C53;
  std::uint32_t layout = 1;
  std::uint32_t vendor = 0;
  std::uint32_t product = 0x534C4B31;
  std::uint32_t board = CutMemory::kBoard;
  std::uint32_t version = 0x00010000;
  std::uint32_t address = 0;
  std::uint32_t size = 0;
  std::uint32_t crc = 0;
  std::uint32_t offset = 0;

  Bytes bytes() const {
    const Bytes head =
        words({magic, layout, vendor, product, board, version, address, size, crc, offset, 0, 0, 0, 0, 0});
    return joined(head, words({crc_by_division(head)}));
  }
};

inline Bytes random_bytes(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() & 0xFFU);
  return bytes;
}

inline HeaderWords header_for(std::size_t slot, const Bytes& program) {
  HeaderWords header;
  header.address = CutMemory::kAddresses[slot];
  header.size = static_cast<std::uint32_t>(program.size());
  header.crc = crc_by_division(program);
  return header;
}
inline Bytes image_for(std::size_t slot, const Bytes& program) {
  return joined(header_for(slot, program).bytes(), program);
}
/// An update file: a program for each slot.
inline Bytes file_of(const std::array<Bytes, 2>& programs) {
  return joined(image_for(0, programs[0]), image_for(1, programs[1]));
}

/// What a slot holds behind its header block.
inline Bytes program_in(const CutMemory& memory, std::size_t slot, std::size_t size) {
  const Bytes& all = memory.slots[slot].bytes;
  return Bytes(all.begin() + 512, all.begin() + 512 + static_cast<std::ptrdiff_t>(size));
}

inline bool holds(const CutMemory& memory, std::size_t slot, const Bytes& program) {
  return std::equal(program.begin(), program.end(), memory.slots[slot].bytes.begin() + 512);
}

/// As a new board comes: an image in slot 0, install 1, that has reported in.
inline void flash_new(CutMemory& memory, const Bytes& program, bool confirmed = true) {
  const Bytes header = header_for(0, program).bytes();
  const Bytes mark = words({1, ~1U});
  Bytes& slot = memory.slots[0].bytes;
  std::copy(header.begin(), header.end(), slot.begin());
  std::copy(mark.begin(), mark.end(), slot.begin() + 64);
  std::copy(program.begin(), program.end(), slot.begin() + 512);
  const Bytes note = words({0x43000001, ~0x43000001U});
  if (confirmed) std::copy(note.begin(), note.end(), memory.note_pages[0].bytes.begin());
}

}  // namespace slipstack::test
