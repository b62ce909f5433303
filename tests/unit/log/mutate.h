// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <random>
#include <string>
#include <string_view>

namespace slipstack::workbench::test {

// Damages a text as editors, cables and other programs do: flips bits, removes, inserts and doubles bytes,
// cuts, moves and repeats parts, inserts tokens that are difficult to parse. Deterministic for a seed.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  std::string mutated(std::string text) {
    const std::size_t rounds = 1 + below(4);
    for (std::size_t i = 0; i < rounds; ++i) mutate_once(text);
    return text;
  }

 private:
  static constexpr std::array<std::string_view, 30> kTokens{",",
                                                            "\n",
                                                            "\r\n",
                                                            "\r",
                                                            "#",
                                                            "# ",
                                                            ":",
                                                            "\"",
                                                            "\t",
                                                            " ",
                                                            "-",
                                                            "+",
                                                            ".",
                                                            "e",
                                                            "nan",
                                                            "inf",
                                                            "1e400",
                                                            "-1e308",
                                                            "1e-400",
                                                            "0",
                                                            "9999999999999999999999",
                                                            "0x1",
                                                            "# mass_kg: 1\n",
                                                            "# sampling: irregular\n",
                                                            "\xEF\xBB\xBF",
                                                            "\xFF\xFE",
                                                            ",,",
                                                            "time_s",
                                                            "position_counts",
                                                            "# encoder_resolution_m: 1e-6\n"};

  std::size_t below(std::size_t limit) { return limit == 0 ? 0 : random_() % limit; }

  void mutate_once(std::string& text) {
    const std::size_t at = below(text.size() + 1);
    const std::size_t length = 1 + below(below(8) == 0 ? text.size() : 12);
    switch (below(9)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        break;
      case 1:
        if (at < text.size()) text[at] = static_cast<char>(below(256));
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(at, text.substr(below(text.size() + 1), length));
        break;
      case 4:
        text.resize(at);
        break;
      case 5:
        text.insert(at, 1, static_cast<char>(below(256)));
        break;
      case 6:
        text.replace(at, below(6), text.substr(below(text.size() + 1), length));
        break;
      case 7:
        mutate_digit(text);
        break;
      default:
        text.insert(at, kTokens[below(kTokens.size())]);
        break;
    }
  }

  // A number replaced by another number reaches later stages of the reader than other damage.
  void mutate_digit(std::string& text) {
    const std::size_t digit = text.find_first_of("0123456789", below(text.size() + 1));
    if (digit != std::string::npos) text[digit] = static_cast<char>('0' + below(10));
  }

  std::mt19937_64 random_;
};

}  // namespace slipstack::workbench::test
