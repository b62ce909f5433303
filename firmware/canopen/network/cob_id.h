// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack::canopen {

/// CAN-IDs that no PDO, SYNC or EMCY may use (CiA 301 table 40).
constexpr bool is_restricted(std::uint32_t id) {
  const auto between = [id](std::uint32_t low, std::uint32_t high) { return id >= low && id <= high; };
  return id == 0 || between(0x001, 0x07F) || between(0x101, 0x180) || between(0x581, 0x5FF) ||
         between(0x601, 0x67F) || between(0x6E0, 0x6FF) || between(0x701, 0x77F) || between(0x780, 0x7FF);
}

}  // namespace slipstack::canopen
