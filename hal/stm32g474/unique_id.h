// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace slipstack::stm32g474 {

// RM0440, Device electronic signature: the unique device ID register, 96 bits, place on the wafer and lot.
inline constexpr std::uint32_t kUniqueId = 0x1FFF7590;

// The 96 bits as 32: FNV-1a over the bytes, since neighbouring parts differ in few bits of a few of them.
// Never zero, which LSS masters take for none.
constexpr std::uint32_t serial_from(const std::array<std::uint32_t, 3>& id) {
  std::uint32_t hash = 2166136261U;
  for (const std::uint32_t word : id) {
    for (unsigned shift = 0; shift < 32; shift += 8) hash = (hash ^ (word >> shift & 0xFFU)) * 16777619U;
  }
  return hash != 0 ? hash : 1;
}

}  // namespace slipstack::stm32g474
