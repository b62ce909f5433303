// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/page/format.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace slipstack::workbench {

std::string escape_html(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') out += c;
    }
  }
  return out;
}

std::string prose_html(std::string_view text) {
  static constexpr std::array<std::string_view, 6> kBare = {"N", "m", "s", "A", "m/s", "Hz"};
  static constexpr std::array<std::string_view, 4> kWhole = {"%", "kg", "degrees", "N/A"};
  const std::string plain = escape_html(text);
  const auto is_unit = [](std::string_view word) {
    if (std::ranges::find(kWhole, word) != kWhole.end() || std::ranges::find(kBare, word) != kBare.end())
      return true;
    return word.size() > 1 && std::string_view("munk").find(word[0]) != std::string_view::npos &&
           std::ranges::find(kBare, word.substr(1)) != kBare.end();
  };
  std::string out;
  out.reserve(plain.size() + plain.size() / 8);
  bool after_number = false;  // the word before was a number with its unit, which may go on ("N s/m")
  for (std::size_t at = 0; at < plain.size();) {
    const std::size_t end = std::min(plain.find_first_of(" ,.;:()\n", at + 1), plain.size());
    const bool digit_before = at > 0 && plain[at - 1] >= '0' && plain[at - 1] <= '9';
    const std::string word = plain[at] == ' ' ? plain.substr(at + 1, end - at - 1) : "";
    const bool unit = digit_before && is_unit(word);
    if (unit || (after_number && word == "s/m")) {
      out += "\u00a0";
      out += word.size() > 1 && word[0] == 'u' ? "\u00b5" + word.substr(1) : word;
    } else {
      out.append(plain, at, end - at);
    }
    after_number = unit;
    at = end;
  }
  return out;
}

}  // namespace slipstack::workbench
