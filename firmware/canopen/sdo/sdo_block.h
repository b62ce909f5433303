// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/canopen/sdo/sdo_access.h"

namespace slipstack::canopen {

inline constexpr std::uint8_t kBlockSegments = 127;
inline constexpr std::size_t kSegmentBytes = 7;

/// CRC of block transfers: CCITT, polynomial 1021h, initial value 0 (CiA 301, 7.2.4.3.16). Check value of
/// "123456789": 31C3h.
constexpr std::uint16_t sdo_crc(std::span<const std::uint8_t> bytes, std::uint16_t crc = 0) {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ (byte << 8));
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>((crc & 0x8000) != 0 ? (crc << 1) ^ 0x1021 : crc << 1);
    }
  }
  return crc;
}

/// The segments of a block download on their way into the object.
class BlockDownload {
 public:
  /// `checked`: the master sends a CRC at the end.
  void begin(bool checked) {
    checked_ = checked;
    crc_ = 0;
    received_ = 0;
    held_ = false;
  }

  /// Segment `number` of the block. Segments are taken in order; what follows a missing one is repeated by
  /// the master in the next block. How many bytes of the last segment count is known at the end only, so the
  /// latest segment is held back. `in_order`: it was taken.
  Abort add(SdoAccess& object, std::uint8_t number, std::span<const std::uint8_t, kSegmentBytes> bytes,
            bool& in_order) {
    in_order = number == received_ + 1;
    if (!in_order) return Abort::kNone;
    if (held_) {
      const Abort code = write(object, kSegmentBytes);
      if (code != Abort::kNone) return code;
    }
    ++received_;
    std::copy(bytes.begin(), bytes.end(), segment_.begin());
    held_ = true;
    return Abort::kNone;
  }

  /// The block is complete: how many of its segments were taken.
  std::uint8_t end_block() {
    const std::uint8_t taken = received_;
    received_ = 0;
    return taken;
  }

  /// The end of the transfer: `count` bytes of the last segment count.
  Abort end(SdoAccess& object, std::size_t count, std::uint16_t crc) {
    const Abort code = write(object, count);
    if (code != Abort::kNone) return code;
    return checked_ && crc != crc_ ? Abort::kCrc : Abort::kNone;
  }

 private:
  Abort write(SdoAccess& object, std::size_t count) {
    held_ = false;
    const std::span<const std::uint8_t> bytes(segment_.data(), count);
    crc_ = sdo_crc(bytes, crc_);
    return object.write(bytes);
  }

  bool checked_ = false;
  bool held_ = false;
  std::uint8_t received_ = 0;
  std::uint16_t crc_ = 0;
  std::array<std::uint8_t, kSegmentBytes> segment_{};
};

}  // namespace slipstack::canopen
