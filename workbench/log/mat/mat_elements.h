// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace slipstack::workbench {

// The bytes of a MAT-file are inconsistent; what() describes the fault without the file's name.
struct MatDamage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Storage types of elements (MAT-File Format, table 1-1).
enum class MatType : std::uint32_t {
  kInt8 = 1,
  kUint8 = 2,
  kInt16 = 3,
  kUint16 = 4,
  kInt32 = 5,
  kUint32 = 6,
  kSingle = 7,
  kDouble = 9,
  kInt64 = 12,
  kUint64 = 13,
  kMatrix = 14,
  kCompressed = 15,
  kUtf8 = 16,
  kUtf16 = 17,
  kUtf32 = 18,
};

struct MatElement {
  MatType type{};
  std::span<const std::byte> data;
};

// Iterates over the elements in a range of bytes of a MAT-file. Never reads beyond the range: an element that
// announces more bytes throws MatDamage.
class MatCursor {
 public:
  // `swapped`: the file's byte order is not this machine's.
  MatCursor(std::span<const std::byte> bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}

  bool at_end() const { return bytes_.empty(); }
  // The next element, in the short or the long form of its tag; the cursor then is behind its padding.
  MatElement next();
  // The same, and throws MatDamage unless it is of `type`.
  MatElement next(MatType type);

 private:
  std::span<const std::byte> bytes_;
  bool swapped_;
};

std::uint32_t mat_uint32(std::span<const std::byte> bytes, bool swapped);

// The numbers of an element of any numeric type. Throws MatDamage when its size is no multiple of a number's.
std::vector<double> mat_numbers(const MatElement& element, bool swapped);

// The characters of an element as UTF-8; what is not a character becomes '?'.
std::string mat_text(const MatElement& element, bool swapped);

// The content of a compressed element (RFC 1950). Throws MatDamage when it is damaged, cut off, or above
// `largest` bytes; never allocates more memory than the compressed bytes can fill.
std::vector<std::byte> mat_inflated(std::span<const std::byte> compressed, bool swapped, std::size_t largest);

}  // namespace slipstack::workbench
