// SPDX-License-Identifier: Apache-2.0
#include "workbench/base/text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <system_error>

namespace slipstack::workbench {
namespace {

constexpr std::size_t kQuoteLimit = 40;  // bytes; chosen, so that a message with two quotes stays one line

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

// Length of the well-formed UTF-8 sequence at the head of `text` (RFC 3629: no overlong forms, no surrogates,
// nothing above U+10FFFF), or 0.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const auto tail = [&](std::size_t i, std::uint8_t low = 0x80, std::uint8_t high = 0xBF) {
    return i < text.size() && byte(i) >= low && byte(i) <= high;
  };
  const std::uint8_t lead = byte(0);
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead <= 0xDF) return tail(1) ? 2 : 0;
  if (lead >= 0xE0 && lead <= 0xEF) {
    const std::uint8_t low = lead == 0xE0 ? 0xA0 : 0x80;
    const std::uint8_t high = lead == 0xED ? 0x9F : 0xBF;
    return tail(1, low, high) && tail(2) ? 3 : 0;
  }
  if (lead >= 0xF0 && lead <= 0xF4) {
    const std::uint8_t low = lead == 0xF0 ? 0x90 : 0x80;
    const std::uint8_t high = lead == 0xF4 ? 0x8F : 0xBF;
    return tail(1, low, high) && tail(2) && tail(3) ? 4 : 0;
  }
  return 0;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

std::string printable(std::string_view text, std::size_t limit) {
  std::string result;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::size_t step = length == 0 ? 1 : length;
    if (limit > 0 && result.size() + step > limit) return result + "...";
    const auto lead = static_cast<std::uint8_t>(text.front());
    if (length == 0) {
      result += '?';
    } else if (lead < 0x20 || lead == 0x7F) {
      result += ' ';
    } else {
      result += text.substr(0, length);
    }
    text.remove_prefix(step);
  }
  return result;
}

std::string in_quotes(std::string_view text) {
  return fmt::format("'{}'", printable(text, kQuoteLimit));
}

std::string joined(const std::vector<std::string>& names) {
  std::string result;
  for (const std::string& name : names) {
    if (!result.empty()) result += ", ";
    result += name;
  }
  return result;
}

std::vector<std::string_view> split_fields(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

const char* parse_double(const char* begin, const char* end, double& value) {
  if (begin != end && *begin == '+') {
    ++begin;
    if (begin == end || *begin == '-') return nullptr;
  }
  const auto [next, error] = std::from_chars(begin, end, value);
  return error == std::errc{} ? next : nullptr;
}

std::string number_fault(std::string_view field) {
  if (field.empty()) return "is empty";
  if (field.front() == '"' || field.front() == '\'') {
    return in_quotes(field) + " is not a number (quotes are not supported)";
  }
  double value = 0.0;
  const char* const end = field.data() + field.size();
  const char* const next = parse_double(field.data(), end, value);
  if (next == end) return std::isfinite(value) ? "" : in_quotes(field) + " is not a finite number";
  if (next == nullptr) {
    const char* const digits = field.front() == '+' ? field.data() + 1 : field.data();
    const auto [stop, error] = std::from_chars(digits, end, value);
    if (error == std::errc::result_out_of_range && stop == end) {
      return in_quotes(field) + " is beyond the range of a number";
    }
  }
  return in_quotes(field) + " is not a number";
}

}  // namespace slipstack::workbench
