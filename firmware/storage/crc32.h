// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace slipstack {

/// CRC-32 of IEEE 802.3 (reflected polynomial EDB88320h, begin and end inverted), by halves of a byte: a
/// table of 16 words. `crc` is the value of the bytes before, 0 at the start. Check
/// value of "123456789": CBF43926h.
inline std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t crc = 0) {
  constexpr std::array<std::uint32_t, 16> kTable = [] {
    std::array<std::uint32_t, 16> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) {
      table[i] = i;
      for (int bit = 0; bit < 4; ++bit) table[i] = (table[i] >> 1) ^ (0xEDB88320U & (0U - (table[i] & 1U)));
    }
    return table;
  }();
  crc = ~crc;
  for (const std::byte byte : bytes) {
    crc ^= std::to_integer<std::uint32_t>(byte);
    crc = (crc >> 4) ^ kTable[crc & 0xF];
    crc = (crc >> 4) ^ kTable[crc & 0xF];
  }
  return ~crc;
}

}  // namespace slipstack
