// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "firmware/storage/crc32.h"

// The header of a program image: what an update file begins with, and what the begin of a slot holds.
// docs/firmware-update.md draws both.
namespace slipstack::update {

/// 1018h:01 and :02. Vendor 0 is no vendor: CiA gives numbers to members only, and slipstack has none.
inline constexpr std::uint32_t kVendorId = 0;
inline constexpr std::uint32_t kProductCode = 0x534C4B31;  ///< "SLK1"
inline constexpr std::uint32_t kRevision = 0x00010000;     ///< 1018h:03

/// From the begin of a slot to the program: the header, the install mark, and what a vector table needs to be
/// aligned (118 vectors: 512 bytes, Armv7-M Architecture Reference Manual, B3.2.5).
inline constexpr std::size_t kHeaderBlock = 512;

/// Sixteen words, little-endian.
struct ImageHeader {
  static constexpr std::uint32_t kMagic = 0x49504C53;     ///< "SLPI"
  static constexpr std::uint32_t kContinue = 0x43504C53;  ///< "SLPC": the rest of a transfer that broke off
  static constexpr std::uint32_t kLayout = 1;

  std::uint32_t magic = kMagic;
  std::uint32_t layout = kLayout;
  std::uint32_t vendor = kVendorId;
  std::uint32_t product = kProductCode;
  std::uint32_t board = 0;    ///< ProgramMemory::board()
  std::uint32_t version = 0;  ///< as 1018h:03
  std::uint32_t address = 0;  ///< of the slot that the image is linked for
  std::uint32_t size = 0;     ///< bytes of the program, without any header
  std::uint32_t crc = 0;      ///< CRC-32 of the program
  std::uint32_t offset = 0;   ///< with kContinue: bytes of the program that were sent before
  std::array<std::uint32_t, 5> reserved{};
  std::uint32_t check = 0;  ///< CRC-32 of the words before

  friend bool operator==(const ImageHeader&, const ImageHeader&) = default;
};
inline constexpr std::size_t kHeaderBytes = sizeof(ImageHeader);
static_assert(kHeaderBytes == 64);

using HeaderBytes = std::array<std::byte, kHeaderBytes>;

inline std::uint32_t check_of(const ImageHeader& header) {
  HeaderBytes bytes;
  std::memcpy(bytes.data(), &header, kHeaderBytes);
  return crc32(std::span(bytes).first(kHeaderBytes - 4));
}

/// The bytes of a header, with its check.
inline HeaderBytes to_bytes(ImageHeader header) {
  header.check = check_of(header);
  HeaderBytes bytes;
  std::memcpy(bytes.data(), &header, kHeaderBytes);
  return bytes;
}

/// False when these are not the bytes of a header, or not all of them as they were written.
inline bool from_bytes(const HeaderBytes& bytes, ImageHeader& header) {
  std::memcpy(&header, bytes.data(), kHeaderBytes);
  const bool known = header.magic == ImageHeader::kMagic || header.magic == ImageHeader::kContinue;
  return known && header.layout == ImageHeader::kLayout && header.check == check_of(header);
}

/// Whether an image is made for this product on this board.
inline bool is_for(const ImageHeader& header, std::uint32_t board) {
  return header.vendor == kVendorId && header.product == kProductCode && header.board == board;
}

}  // namespace slipstack::update
