// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "firmware/storage/crc32.h"
#include "hal/include/nonvolatile.h"

namespace slipstack {

enum class StoreStatus : std::uint8_t {
  kOk,
  kNothingStored,
  kTooLarge,     ///< the record does not fit a slot, or the reader's buffer
  kDeviceError,  ///< the device refused, or what was written reads back differently
};

/// Records in flash that survive a power cut at any instant: after it, the record before or the new one is
/// there, whole.
///
/// The pages form two slots. A record is a header (magic, sequence number, size, erasures of either slot),
/// the payload, and a CRC-32 over both in the last unit written. Records are appended to the slot that holds
/// the newest one; when it is full, or what follows is not blank (a store that was cut), the other slot is
/// erased and takes the record. The slot that holds the newest record is never erased. The highest sequence
/// number with a right CRC wins.
///
/// Wear: erasures() counts each slot; the counts travel in the records. An erasure after which power failed
/// before a record was complete is not counted.
///
/// Used outside the tick. store() takes as long as the device: an erasure at most, and the record.
class RecordSlots {
 public:
  static constexpr std::size_t kHeaderBytes = 24;
  static constexpr std::size_t kLargestUnit = 32;

  explicit RecordSlots(Nonvolatile& device) : device_(device) {}

  /// Finds the newest record. Reads every record once.
  StoreStatus mount() {
    found_ = false;
    sequence_ = 0;
    erasures_ = {};
    for (std::size_t slot = 0; slot < 2; ++slot) scan(slot);
    return found_ ? StoreStatus::kOk : StoreStatus::kNothingStored;
  }

  /// Copies the newest record to `out`; `size` is what it holds.
  StoreStatus load(std::span<std::byte> out, std::size_t& size) const {
    size = 0;
    if (!found_) return StoreStatus::kNothingStored;
    if (newest_size_ > out.size()) return StoreStatus::kTooLarge;
    if (!read(newest_slot_, newest_at_ + header_bytes(), out.first(newest_size_)))
      return StoreStatus::kDeviceError;
    size = newest_size_;
    return StoreStatus::kOk;
  }

  /// The begin of the newest record. False: there is none, or it is shorter.
  bool load_begin(std::span<std::byte> out) const {
    return found_ && newest_size_ >= out.size() && read(newest_slot_, newest_at_ + header_bytes(), out);
  }

  /// Writes a record. On failure the one before is still the newest.
  StoreStatus store(std::span<const std::byte> payload) {
    const std::size_t need = record_bytes(payload.size());
    if (device_.write_unit() > kLargestUnit || need > slot_bytes() || payload.size() > 0xFFFF) {
      return StoreStatus::kTooLarge;
    }
    std::size_t slot = newest_slot_;
    std::size_t at = end_;
    if (!found_ || at + need > slot_bytes() || !blank(slot, at, need)) {
      slot = found_ ? newest_slot_ ^ 1U : 0;
      at = 0;
      if (!erase(slot)) return StoreStatus::kDeviceError;
    }
    if (!write_record(slot, at, payload)) {
      // What lies there is not blank any more: the next store takes the other slot, and another number, lest
      // two records had the same.
      ++sequence_;
      if (found_ && slot == newest_slot_) end_ = slot_bytes();
      return StoreStatus::kDeviceError;
    }
    found_ = true;
    ++sequence_;
    newest_slot_ = slot;
    newest_at_ = at;
    newest_size_ = payload.size();
    end_ = at + need;
    return StoreStatus::kOk;
  }

  /// Takes over the newest record of another log if it is newer. On failure the one before stays the newest.
  StoreStatus adopt(const RecordSlots& other) {
    if (!other.found_ || (found_ && static_cast<std::int32_t>(other.sequence_ - sequence_) <= 0)) {
      return StoreStatus::kOk;
    }
    if (record_bytes(other.newest_size_) > slot_bytes()) return StoreStatus::kTooLarge;
    const std::size_t slot = found_ ? newest_slot_ ^ 1U : 0;
    if (!erase(slot) || !copy_record(slot, other)) return StoreStatus::kDeviceError;
    found_ = true;
    sequence_ = other.sequence_;
    newest_slot_ = slot;
    newest_at_ = 0;
    newest_size_ = other.newest_size_;
    end_ = record_bytes(newest_size_);
    return StoreStatus::kOk;
  }

  /// The largest payload that fits.
  std::size_t capacity() const {
    const std::size_t fixed = header_bytes() + trailer_bytes();
    return slot_bytes() > fixed ? (slot_bytes() - fixed) / device_.write_unit() * device_.write_unit() : 0;
  }
  std::uint32_t sequence() const { return sequence_; }
  std::uint32_t erasures(std::size_t slot) const { return erasures_[slot]; }

 private:
  static constexpr std::uint32_t kMagic = 0x534C4C47;  // "SLLG"
  struct Header {
    std::uint32_t magic, sequence, size, erasures[2], inverse;
  };
  static_assert(sizeof(Header) == kHeaderBytes);

  std::size_t up(std::size_t bytes) const {
    const std::size_t unit = device_.write_unit();
    return (bytes + unit - 1) / unit * unit;
  }
  std::size_t header_bytes() const { return up(kHeaderBytes); }
  std::size_t trailer_bytes() const { return up(4); }
  std::size_t record_bytes(std::size_t size) const { return header_bytes() + up(size) + trailer_bytes(); }
  std::size_t pages_per_slot() const { return device_.page_count() / 2; }
  std::size_t slot_bytes() const { return pages_per_slot() * device_.page_size(); }

  // Calls `work(page, offset, bytes)` for each page that a range of a slot touches.
  template <class Bytes, class Work>
  bool by_page(std::size_t slot, std::size_t at, Bytes bytes, Work&& work) const {
    while (!bytes.empty()) {
      const std::size_t offset = at % device_.page_size();
      const std::size_t count = std::min<std::size_t>(bytes.size(), device_.page_size() - offset);
      if (!work(slot * pages_per_slot() + at / device_.page_size(), offset, bytes.first(count))) return false;
      bytes = bytes.subspan(count);
      at += count;
    }
    return true;
  }
  bool read(std::size_t slot, std::size_t at, std::span<std::byte> out) const {
    if (at + out.size() > slot_bytes()) return false;
    return by_page(slot, at, out, [this](std::size_t page, std::size_t offset, std::span<std::byte> part) {
      return device_.read(page, offset, part) == NonvolatileStatus::kOk;
    });
  }
  bool write(std::size_t slot, std::size_t at, std::span<const std::byte> data) {
    return by_page(slot, at, data,
                   [this](std::size_t page, std::size_t offset, std::span<const std::byte> part) {
                     return device_.write(page, offset, part) == NonvolatileStatus::kOk;
                   });
  }
  bool erase(std::size_t slot) {
    for (std::size_t page = 0; page < pages_per_slot(); ++page) {
      if (device_.erase(slot * pages_per_slot() + page) != NonvolatileStatus::kOk) return false;
    }
    if (erasures_[slot] < 0xFFFFFFFF) ++erasures_[slot];
    return true;
  }
  bool blank(std::size_t slot, std::size_t at, std::size_t size) const {
    std::array<std::byte, kLargestUnit> part;
    for (std::size_t done = 0; done < size; done += device_.write_unit()) {
      const std::span<std::byte> bytes(part.data(), device_.write_unit());
      if (!read(slot, at + done, bytes)) return false;
      if (std::any_of(bytes.begin(), bytes.end(), [](std::byte b) { return b != std::byte{0xFF}; }))
        return false;
    }
    return true;
  }

  bool write_record(std::size_t slot, std::size_t at, std::span<const std::byte> payload) {
    Header header{kMagic,
                  sequence_ + 1,
                  static_cast<std::uint32_t>(payload.size()),
                  {erasures_[0], erasures_[1]},
                  ~static_cast<std::uint32_t>(payload.size())};
    std::array<std::byte, kHeaderBytes> bytes;
    std::memcpy(bytes.data(), &header, kHeaderBytes);
    const std::uint32_t crc = crc32(payload, crc32(bytes));
    if (!write_padded(slot, at, bytes)) return false;
    at += header_bytes();
    if (!write_padded(slot, at, payload)) return false;
    at += up(payload.size());
    std::array<std::byte, 4> trailer;
    std::memcpy(trailer.data(), &crc, 4);
    if (!write_padded(slot, at, trailer)) return false;
    std::size_t size = 0;
    std::uint32_t sequence = 0;
    return check(slot, at - up(payload.size()) - header_bytes(), sequence, size) && sequence == sequence_ + 1;
  }

  // Another log's newest record at the begin of a slot, with the erasures of this one.
  bool copy_record(std::size_t slot, const RecordSlots& other) {
    const auto size = static_cast<std::uint32_t>(other.newest_size_);
    const Header header{kMagic, other.sequence_, size, {erasures_[0], erasures_[1]}, ~size};
    std::array<std::byte, kHeaderBytes> bytes;
    std::memcpy(bytes.data(), &header, kHeaderBytes);
    std::uint32_t crc = crc32(bytes);
    if (!write_padded(slot, 0, bytes)) return false;
    std::array<std::byte, kLargestUnit> part;
    for (std::size_t done = 0; done < size; done += part.size()) {
      const auto payload = std::span(part).first(std::min<std::size_t>(part.size(), size - done));
      if (!other.read(other.newest_slot_, other.newest_at_ + other.header_bytes() + done, payload))
        return false;
      crc = crc32(payload, crc);
      if (!write_padded(slot, header_bytes() + done, payload)) return false;
    }
    std::array<std::byte, 4> trailer;
    std::memcpy(trailer.data(), &crc, 4);
    if (!write_padded(slot, header_bytes() + up(size), trailer)) return false;
    std::uint32_t sequence = 0;
    std::size_t checked = 0;
    return check(slot, 0, sequence, checked) && checked == size;
  }

  // Whole units as they are, the last one filled up with FFh.
  bool write_padded(std::size_t slot, std::size_t at, std::span<const std::byte> data) {
    const std::size_t whole = data.size() / device_.write_unit() * device_.write_unit();
    if (!write(slot, at, data.first(whole))) return false;
    if (whole == data.size()) return true;
    std::array<std::byte, kLargestUnit> last;
    last.fill(std::byte{0xFF});
    std::copy(data.begin() + static_cast<std::ptrdiff_t>(whole), data.end(), last.begin());
    return write(slot, at + whole, std::span<const std::byte>(last.data(), device_.write_unit()));
  }

  bool read_header(std::size_t slot, std::size_t at, Header& header) const {
    std::array<std::byte, kHeaderBytes> bytes;
    if (!read(slot, at, bytes)) return false;
    std::memcpy(&header, bytes.data(), kHeaderBytes);
    return header.magic == kMagic && header.size == ~header.inverse &&
           record_bytes(header.size) <= slot_bytes() - at;
  }

  // A whole record with a right CRC?
  bool check(std::size_t slot, std::size_t at, std::uint32_t& sequence, std::size_t& size) const {
    Header header;
    if (!read_header(slot, at, header)) return false;
    std::array<std::byte, kHeaderBytes> head;
    std::memcpy(head.data(), &header, kHeaderBytes);
    std::uint32_t crc = crc32(head);
    std::array<std::byte, kLargestUnit> part;
    for (std::size_t done = 0; done < header.size; done += part.size()) {
      const std::span<std::byte> bytes(part.data(), std::min<std::size_t>(part.size(), header.size - done));
      if (!read(slot, at + header_bytes() + done, bytes)) return false;
      crc = crc32(bytes, crc);
    }
    std::array<std::byte, 4> trailer;
    if (!read(slot, at + header_bytes() + up(header.size), trailer)) return false;
    std::uint32_t stored = 0;
    std::memcpy(&stored, trailer.data(), 4);
    sequence = header.sequence;
    size = header.size;
    return stored == crc;
  }

  // Follows the records of a slot. Ends at the first that is none: behind a store that was cut nothing is
  // appended before the slot has been erased, so that nothing is missed.
  void scan(std::size_t slot) {
    std::size_t at = 0;
    while (at + header_bytes() <= slot_bytes()) {
      std::uint32_t sequence = 0;
      std::size_t size = 0;
      if (!check(slot, at, sequence, size)) return;
      const std::size_t end = at + record_bytes(size);
      if (!found_ || static_cast<std::int32_t>(sequence - sequence_) > 0) {
        found_ = true;
        sequence_ = sequence;
        newest_slot_ = slot;
        newest_at_ = at;
        newest_size_ = size;
        end_ = end;
        Header header;
        if (read_header(slot, at, header)) erasures_ = {header.erasures[0], header.erasures[1]};
      }
      at = end;
    }
  }

  Nonvolatile& device_;
  bool found_ = false;
  std::uint32_t sequence_ = 0;
  std::size_t newest_slot_ = 0;
  std::size_t newest_at_ = 0;
  std::size_t newest_size_ = 0;
  std::size_t end_ = 0;
  std::array<std::uint32_t, 2> erasures_{};
};

}  // namespace slipstack
