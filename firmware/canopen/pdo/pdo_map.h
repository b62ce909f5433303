// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/canopen/network/counter.h"
#include "firmware/canopen/objects/communication_objects.h"
#include "firmware/canopen/objects/dictionary.h"

namespace slipstack::canopen {

/// A mapping in the form that transfers use: rows and bits, in order.
class PdoMap {
 public:
  /// Whether one mapping entry may stand in a PDO that way.
  static Abort check_entry(std::uint32_t entry, bool receive) {
    const auto index = static_cast<std::uint16_t>(entry >> 16);
    const auto sub = static_cast<std::uint8_t>(entry >> 8);
    const auto bits = static_cast<std::uint8_t>(entry);
    if (receive && is_dummy(index, sub)) {
      return bits == 8 * size_of(static_cast<Type>(index)) ? Abort::kNone : Abort::kNotMappable;
    }
    const std::size_t row = find_row(index, sub);
    if (row == kNoRow) return has_index(index) ? Abort::kNoSubIndex : Abort::kNoObject;
    const Object& object = kObjects[row];
    const bool allowed = object.mapping == Mapping::kBoth ||
                         object.mapping == (receive ? Mapping::kReceive : Mapping::kTransmit);
    return allowed && bits == 8 * size_of(object.type) ? Abort::kNone : Abort::kNotMappable;
  }

  /// Takes the first `count` entries. Nothing changes unless kNone.
  Abort build(std::span<const std::uint32_t> entries, bool receive) {
    PdoMap made;
    for (const std::uint32_t entry : entries) {
      const Abort code = check_entry(entry, receive);
      if (code != Abort::kNone) return code;
      const auto index = static_cast<std::uint16_t>(entry >> 16);
      const std::size_t bytes = (entry & 0xFF) / 8;
      if (made.bytes_ + bytes > 8) return Abort::kMappingTooLong;
      made.row_[made.count_] =
          is_dummy(index, 0) && receive ? kNoRow : find_row(index, static_cast<std::uint8_t>(entry >> 8));
      made.size_[made.count_++] = static_cast<std::uint8_t>(bytes);
      made.bytes_ = static_cast<std::uint8_t>(made.bytes_ + bytes);
    }
    *this = made;
    return Abort::kNone;
  }

  std::uint8_t bytes() const { return bytes_; }

  /// The values of one tick: read again when a tick came in between, which is far longer than a reading.
  /// Whether `row` is among the entries of which `taken` has a bit.
  bool took(std::size_t row, std::uint8_t taken) const {
    for (std::size_t i = 0; i < count_; ++i) {
      if (row_[i] == row && (taken >> i & 1U) != 0) return true;
    }
    return false;
  }

  void pack(Dictionary& dictionary, std::span<std::uint8_t, 8> out) const {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t before = dictionary.access().tick();
      read_all(dictionary, out);
      if (dictionary.access().tick() == before) return;
    }
  }
  /// Puts the values into the dictionary; nothing follows from them before announce(). Those that it refuses
  /// are counted in `refused`; the others are taken. A bit in the result for each that was.
  std::uint8_t unpack(Dictionary& dictionary, std::span<const std::uint8_t> in,
                      std::uint32_t& refused) const {
    std::size_t at = 0;
    std::uint8_t taken = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (row_[i] != kNoRow) {
        const std::uint32_t value = from_bytes(kObjects[row_[i]].type, in.subspan(at, size_[i]));
        if (dictionary.put(row_[i], value) == Abort::kNone) {
          taken = static_cast<std::uint8_t>(taken | (1U << i));
        } else {
          count(refused);
        }
      }
      at += size_[i];
    }
    return taken;
  }
  /// The device acts on what unpack() took: on all of it together, so that a controlword meets the target
  /// that came with it, in whichever order they are mapped.
  void announce(Dictionary& dictionary, std::uint8_t taken) const {
    for (std::size_t i = 0; i < count_; ++i) {
      if ((taken >> i & 1U) != 0) dictionary.announce(row_[i]);
    }
  }

 private:
  void read_all(Dictionary& dictionary, std::span<std::uint8_t, 8> out) const {
    std::size_t at = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      to_bytes(dictionary.read(row_[i]), out.subspan(at, size_[i]));
      at += size_[i];
    }
  }

  // Entries for the basic types: bytes that are ignored.
  static bool is_dummy(std::uint16_t index, std::uint8_t sub) { return sub == 0 && index >= 1 && index <= 7; }

  std::array<std::size_t, kMappedLargest> row_{};
  std::array<std::uint8_t, kMappedLargest> size_{};
  std::uint8_t count_ = 0;
  std::uint8_t bytes_ = 0;
};

}  // namespace slipstack::canopen
