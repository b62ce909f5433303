// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace slipstack {

enum class NonvolatileStatus : std::uint8_t { kOk, kOutOfRange, kMisaligned, kNotErased, kDeviceError };

/// Flash pages for parameters, used outside the tick. Erasing sets every byte to 0xFF; a unit of
/// `write_unit()` bytes is written once between erasures. Power may fail in any call: the page, or unit, it
/// was about holds anything afterwards, every other byte what it held. Erasing may stop the processor for
/// milliseconds (say so in the board's page).
class Nonvolatile {
 public:
  virtual std::size_t page_count() const = 0;
  virtual std::size_t page_size() const = 0;   ///< bytes
  virtual std::size_t write_unit() const = 0;  ///< bytes, a power of two
  virtual NonvolatileStatus read(std::size_t page, std::size_t offset, std::span<std::byte> out) const = 0;
  /// `offset` and the size of `data` are multiples of write_unit().
  virtual NonvolatileStatus write(std::size_t page, std::size_t offset, std::span<const std::byte> data) = 0;
  virtual NonvolatileStatus erase(std::size_t page) = 0;

 protected:
  ~Nonvolatile() = default;
};

}  // namespace slipstack
