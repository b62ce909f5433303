// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/html/format.h"

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
  static constexpr std::array<std::string_view, 8> kBare = {"N", "m", "s", "A", "m/s", "Hz", "rad", "rad/s"};
  static constexpr std::array<std::string_view, 8> kWhole = {"%",   "kg",  "degrees", "N/A",
                                                             "deg", "rev", "deg/s",   "rev/s"};
  // The rest of a unit in several words: "N s/m", "N m", "kg m2".
  static constexpr std::array<std::string_view, 6> kFurther = {"s/m", "m", "s/rad", "m/rad", "s", "m2"};
  std::string plain = escape_html(text);
  constexpr std::string_view kTyped = "+-";  // what a terminal of any encoding shows
  for (std::size_t at = 0; (at = plain.find(" +- ", at)) != std::string::npos;)
    plain.replace(at + 1, kTyped.size(), "\u00b1");
  const auto is_unit = [](std::string_view word) {
    if (std::ranges::find(kWhole, word) != kWhole.end() || std::ranges::find(kBare, word) != kBare.end())
      return true;
    return word.size() > 1 && std::string_view("munk").find(word[0]) != std::string_view::npos &&
           std::ranges::find(kBare, word.substr(1)) != kBare.end();
  };
  std::string out;
  out.reserve(plain.size() + plain.size() / 8);
  bool after_number = false;  // the word before was a unit after a number; the unit may continue
  for (std::size_t at = 0; at < plain.size();) {
    const std::size_t end = std::min(plain.find_first_of(" ,.;:()\n", at + 1), plain.size());
    const bool digit_before = at > 0 && plain[at - 1] >= '0' && plain[at - 1] <= '9';
    const std::string word = plain[at] == ' ' ? plain.substr(at + 1, end - at - 1) : "";
    const bool unit = digit_before && is_unit(word);
    const bool further = after_number && std::ranges::find(kFurther, word) != kFurther.end();
    if (unit || further) {
      out += "\u00a0";
      out += word.size() > 1 && word[0] == 'u' ? "\u00b5" + word.substr(1) : word;
    } else {
      out.append(plain, at, end - at);
    }
    after_number = unit || further;
    at = end;
  }
  return out;
}

}  // namespace slipstack::workbench
