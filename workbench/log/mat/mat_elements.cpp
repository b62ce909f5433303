// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/mat/mat_elements.h"

// Makes zlib declare its input as const.
#define ZLIB_CONST
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "workbench/log/utf8.h"

namespace slipstack::workbench {
namespace {

constexpr std::size_t kTagSize = 8;
constexpr std::size_t kPadding = 8;
constexpr std::size_t kShortCapacity = 4;  // bytes of data that fit into the tag itself

template <typename Number>
Number load(const std::byte* from, bool swapped) {
  std::array<std::byte, sizeof(Number)> bytes{};
  std::memcpy(bytes.data(), from, bytes.size());
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Number>(bytes);
}

template <typename Number>
std::vector<double> loaded(std::span<const std::byte> data, bool swapped) {
  if (data.size() % sizeof(Number) != 0) throw MatDamage("a vector ends within a number");
  std::vector<double> values(data.size() / sizeof(Number));
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<double>(load<Number>(data.data() + i * sizeof(Number), swapped));
  }
  return values;
}

class Inflater {
 public:
  explicit Inflater(std::span<const std::byte> compressed) {
    stream_.next_in = reinterpret_cast<const Bytef*>(compressed.data());
    stream_.avail_in = static_cast<uInt>(compressed.size());
    if (inflateInit(&stream_) != Z_OK) throw MatDamage("a compressed variable cannot be opened");
  }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  void fill(std::span<std::byte> output) {
    stream_.next_out = reinterpret_cast<Bytef*>(output.data());
    stream_.avail_out = static_cast<uInt>(output.size());
    const int status = inflate(&stream_, Z_SYNC_FLUSH);
    if ((status == Z_OK || status == Z_STREAM_END) && stream_.avail_out == 0) return;
    throw MatDamage("a compressed variable is damaged");
  }

  // Reads up to the checksum, which zlib verifies.
  void finish() {
    std::array<Bytef, 16> rest{};
    stream_.next_out = rest.data();
    stream_.avail_out = rest.size();
    if (inflate(&stream_, Z_FINISH) != Z_STREAM_END) throw MatDamage("a compressed variable is damaged");
  }

 private:
  z_stream stream_{};
};

}  // namespace

std::uint32_t mat_uint32(std::span<const std::byte> bytes, bool swapped) {
  if (bytes.size() < 4) throw MatDamage("a number is cut off");
  return load<std::uint32_t>(bytes.data(), swapped);
}

MatElement MatCursor::next() {
  if (bytes_.size() < kTagSize) throw MatDamage("the file is cut off");
  const std::uint32_t first = mat_uint32(bytes_, swapped_);
  const std::size_t short_length = first >> 16;
  if (short_length > 0) {
    if (short_length > kShortCapacity) throw MatDamage("the size of an element is impossible");
    const MatElement element{static_cast<MatType>(first & 0xFFFF), bytes_.subspan(4, short_length)};
    bytes_ = bytes_.subspan(kTagSize);
    return element;
  }
  const std::size_t length = mat_uint32(bytes_.subspan(4), swapped_);
  bytes_ = bytes_.subspan(kTagSize);
  if (length > bytes_.size()) throw MatDamage("the file is cut off");
  const MatElement element{static_cast<MatType>(first), bytes_.first(length)};
  const std::size_t padded = (length + kPadding - 1) / kPadding * kPadding;
  bytes_ = bytes_.subspan(std::min(padded, bytes_.size()));
  return element;
}

MatElement MatCursor::next(MatType type) {
  const MatElement element = next();
  if (element.type != type) throw MatDamage("an element is of a wrong type");
  return element;
}

std::vector<double> mat_numbers(const MatElement& element, bool swapped) {
  switch (element.type) {
    case MatType::kInt8:
      return loaded<std::int8_t>(element.data, swapped);
    case MatType::kUint8:
      return loaded<std::uint8_t>(element.data, swapped);
    case MatType::kInt16:
      return loaded<std::int16_t>(element.data, swapped);
    case MatType::kUint16:
      return loaded<std::uint16_t>(element.data, swapped);
    case MatType::kInt32:
      return loaded<std::int32_t>(element.data, swapped);
    case MatType::kUint32:
      return loaded<std::uint32_t>(element.data, swapped);
    case MatType::kSingle:
      return loaded<float>(element.data, swapped);
    case MatType::kDouble:
      return loaded<double>(element.data, swapped);
    case MatType::kInt64:
      return loaded<std::int64_t>(element.data, swapped);
    case MatType::kUint64:
      return loaded<std::uint64_t>(element.data, swapped);
    default:
      throw MatDamage("numbers are stored in an unknown type");
  }
}

std::string mat_text(const MatElement& element, bool swapped) {
  const std::span<const std::byte> data = element.data;
  std::string text;
  switch (element.type) {
    case MatType::kInt8:
    case MatType::kUint8:
    case MatType::kUtf8:
      text.assign(reinterpret_cast<const char*>(data.data()), data.size());
      return text;
    case MatType::kUint16:
    case MatType::kUtf16:
      for (std::size_t i = 0; i + 2 <= data.size(); i += 2) {
        append_utf8(text, load<std::uint16_t>(data.data() + i, swapped));
      }
      return text;
    case MatType::kUtf32:
      for (std::size_t i = 0; i + 4 <= data.size(); i += 4) {
        append_utf8(text, load<std::uint32_t>(data.data() + i, swapped));
      }
      return text;
    default:
      throw MatDamage("text is stored in an unknown type");
  }
}

std::vector<std::byte> mat_inflated(std::span<const std::byte> compressed, bool swapped,
                                    std::size_t largest) {
  constexpr std::size_t kBestRatio = 1032;  // limit of deflate (zlib technical details, "Maximum compression
                                            // factor")
  Inflater inflater(compressed);
  std::vector<std::byte> bytes(kTagSize);
  inflater.fill(bytes);
  const std::size_t length = mat_uint32(std::span(bytes).subspan(4), swapped);
  if (length > largest) throw MatDamage("a variable is larger than this program reads");
  if (length > compressed.size() * kBestRatio) throw MatDamage("the size of a variable is impossible");
  bytes.resize(kTagSize + length);
  if (length > 0) inflater.fill(std::span(bytes).subspan(kTagSize));
  inflater.finish();
  return bytes;
}

}  // namespace slipstack::workbench
