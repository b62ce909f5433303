// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace slipstack {

/// CRC-32 of IEEE 802.3 (reflected polynomial EDB88320h, begin and end inverted), bit by bit: 8 steps a byte,
/// no table. `crc` is the value of the bytes before, 0 at the start. Check value of "123456789": CBF43926h.
inline std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t crc = 0) {
  crc = ~crc;
  for (const std::byte byte : bytes) {
    crc ^= std::to_integer<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xEDB88320U & (0U - (crc & 1U)));
  }
  return ~crc;
}

}  // namespace slipstack
