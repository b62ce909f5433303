// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <string_view>

namespace slipstack::test {

/// How many damaged inputs a test tries: a fifth under sanitizers, where each exception of a parser costs
/// some fifty times as much.
constexpr int damaged_inputs(int usual) {
#ifdef SLIPSTACK_SANITIZED
  return usual / 5;
#else
  return usual;
#endif
}

/// Damages a text as editors, cables, merges and other programs do: bits flip, bytes are lost, added or
/// doubled, pieces and lines are cut, moved or repeated, digits change, tokens that the parser of the format
/// may fail on are put in. Deterministic for a seed.
class Mutator {
 public:
  /// `tokens`: of the format under test; they outlive the mutator. At least one.
  Mutator(std::uint64_t seed, std::span<const std::string_view> tokens) : random_(seed), tokens_(tokens) {}

  std::string mutated(std::string text) {
    const std::size_t rounds = 1 + below(4);
    for (std::size_t i = 0; i < rounds; ++i) mutate_once(text);
    return text;
  }

 private:
  std::size_t below(std::size_t limit) { return limit == 0 ? 0 : random_() % limit; }

  void mutate_once(std::string& text) {
    const std::size_t at = below(text.size() + 1);
    const std::size_t length = 1 + below(below(8) == 0 ? text.size() : 12);
    switch (below(12)) {
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
        insert_line_elsewhere(text, true);
        break;
      case 8:
        insert_line_elsewhere(text, false);
        break;
      case 9:
      case 10:
        change_digit(text);
        break;
      default:
        text.insert(at, tokens_[below(tokens_.size())]);
        break;
    }
  }

  void insert_line_elsewhere(std::string& text, bool keep) {
    const std::size_t begin = text.rfind('\n', below(text.size() + 1));
    if (begin == std::string::npos) return;
    const std::size_t end = text.find('\n', begin + 1);
    const std::string line = text.substr(begin, end == std::string::npos ? end : end - begin);
    if (!keep) text.erase(begin, line.size());
    const std::size_t to = text.rfind('\n', below(text.size() + 1));
    text.insert(to == std::string::npos ? 0 : to, line);
  }

  // A number that stays a number gets further into the parser than other damage.
  void change_digit(std::string& text) {
    const std::size_t digit = text.find_first_of("0123456789", below(text.size() + 1));
    if (digit != std::string::npos) text[digit] = below(8) == 0 ? '-' : static_cast<char>('0' + below(10));
  }

  std::mt19937_64 random_;
  std::span<const std::string_view> tokens_;
};

}  // namespace slipstack::test
