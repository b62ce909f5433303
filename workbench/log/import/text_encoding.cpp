// SPDX-License-Identifier: Apache-2.0
#include "workbench/log/import/text_encoding.h"

#include <cstddef>
#include <cstdint>

#include "workbench/base/text.h"
#include "workbench/log/utf8.h"

namespace slipstack::workbench {
namespace {

std::string from_utf16(std::string_view bytes, bool little) {
  const auto unit = [&](std::size_t i) {
    const auto first = static_cast<std::uint8_t>(bytes[i]);
    const auto second = static_cast<std::uint8_t>(bytes[i + 1]);
    return static_cast<std::uint32_t>(little ? first | (second << 8U) : (first << 8U) | second);
  };
  std::string out;
  out.reserve(bytes.size() / 2);
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    std::uint32_t code = unit(i);
    if (code >= 0xD800 && code < 0xDC00 && i + 3 < bytes.size()) {
      code = 0x10000 + ((code - 0xD800) << 10U) + (unit(i + 2) - 0xDC00);
      i += 2;
    }
    if (code != 0xFEFF) append_utf8(out, code);
  }
  return out;
}

bool is_utf8(std::string_view bytes) {
  return printable(bytes).find('?') == std::string::npos || bytes.find('?') != std::string_view::npos;
}

}  // namespace

std::string encoding_of(std::string_view bytes) {
  if (bytes.substr(0, 2) == "\xFF\xFE") return "utf-16le";
  if (bytes.substr(0, 2) == "\xFE\xFF") return "utf-16be";
  const std::string_view head = bytes.substr(0, 512);
  const auto zeros = [&](std::size_t from) {
    std::size_t count = 0;
    for (std::size_t i = from; i < head.size(); i += 2) count += head[i] == '\0' ? 1 : 0;
    return count;
  };
  if (head.size() >= 8 && zeros(1) > head.size() / 4) return "utf-16le";
  if (head.size() >= 8 && zeros(0) > head.size() / 4) return "utf-16be";
  return is_utf8(bytes) ? "utf-8" : "latin-1";
}

std::string decoded(std::string_view bytes, const std::string& encoding) {
  if (encoding == "utf-16le") return from_utf16(bytes, true);
  if (encoding == "utf-16be") return from_utf16(bytes, false);
  if (encoding == "latin-1") {
    std::string out;
    out.reserve(bytes.size());
    for (const char c : bytes) append_utf8(out, static_cast<std::uint8_t>(c));
    return out;
  }
  if (bytes.substr(0, 3) == "\xEF\xBB\xBF") bytes.remove_prefix(3);
  return std::string(bytes);
}

}  // namespace slipstack::workbench
