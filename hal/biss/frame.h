// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

// A frame of BiSS-C (BiSS Interface, Protocol Description C-mode, iC-Haus: single cycle data), one slave,
// point to point. As the master samples SLO, first bit first:
//
//   1 ... 1   until the encoder answers: at least one; line delay
//   0 ... 0   acknowledge: at least one; as long as the position is being taken
//   1         start
//   0 or 1    CDS, control data of the slave, not used
//   position, highest bit first
//   error, warning: 0 is active
//   CRC-6 of position, error and warning by x^6 + x + 1 from 0, highest bit first, inverted
namespace slipstack::biss {

enum class Reception : std::uint8_t {
  kGood,
  kSilent,  ///< no answer: cable, supply, or an encoder that was not ready
  kBadCrc,
  kError,  ///< a whole frame, in which the encoder says that its position is wrong
};

struct Frame {
  Reception reception = Reception::kSilent;
  bool warning = false;
  std::uint64_t position = 0;
};

namespace detail {

// The remainder of six bits more: CRC and data are equally wide, so that one look-up takes both.
inline constexpr auto kCrc6 = [] {
  constexpr unsigned kPolynomial = 0x43;
  std::array<std::uint8_t, 64> table{};
  for (unsigned i = 0; i < table.size(); ++i) {
    unsigned rest = i;
    for (int bit = 0; bit < 6; ++bit) rest = (rest & 0x20U) != 0 ? (rest << 1U) ^ kPolynomial : rest << 1U;
    table[i] = static_cast<std::uint8_t>(rest & 0x3FU);
  }
  return table;
}();

// `count` bits, 1 to 64, from bit `first` on, counted from the highest of the first byte.
constexpr std::uint64_t bits(std::span<const std::uint8_t> bytes, unsigned first, unsigned count) {
  const unsigned last = first + count;
  std::uint64_t word = 0;
  for (unsigned byte = first / 8; byte < last / 8; ++byte) word = word << 8U | bytes[byte];
  if (last % 8 != 0) word = word << last % 8 | bytes[last / 8] >> (8 - last % 8);
  return count < 64 ? word & ((std::uint64_t{1} << count) - 1) : word;
}

}  // namespace detail

/// CRC-6 of the lowest `count` bits, not inverted. Zeros in front change nothing, since it begins with 0.
constexpr unsigned crc6(std::uint64_t data, unsigned count) {
  unsigned crc = 0;
  for (unsigned left = (count + 5) / 6; left > 0; --left) {
    crc = detail::kCrc6[crc ^ static_cast<unsigned>(data >> 6 * (left - 1) & 0x3FU)];
  }
  return crc;
}

/// The frame in what was sampled, for an encoder of 8 to 56 bits. O(bits).
constexpr Frame decode(std::span<const std::uint8_t> sampled, unsigned position_bits) {
  constexpr unsigned kHead = 64;  // the start bit lies in the first bits, or there is none
  if (sampled.size() < kHead / 8) return {};
  const std::uint64_t head = detail::bits(sampled, 0, kHead);
  const auto silent = static_cast<unsigned>(std::countl_one(head));
  if (silent == 0 || silent == kHead) return {};
  const auto start = static_cast<unsigned>(std::countl_zero(head << silent)) + silent;
  constexpr unsigned kStartAndCds = 2;
  constexpr unsigned kFlags = 2;
  constexpr unsigned kCrc = 6;
  const unsigned checked = position_bits + kFlags;
  if (start >= kHead || start + kStartAndCds + checked + kCrc > 8 * sampled.size()) return {};
  const std::uint64_t word = detail::bits(sampled, start + kStartAndCds, checked + kCrc);
  const std::uint64_t data = word >> kCrc;
  if ((crc6(data, checked) ^ 0x3FU) != (word & 0x3FU)) return {.reception = Reception::kBadCrc};
  return {(data & 2U) == 0 ? Reception::kError : Reception::kGood, (data & 1U) == 0, data >> kFlags};
}

}  // namespace slipstack::biss
