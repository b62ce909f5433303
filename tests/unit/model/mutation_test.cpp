// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <string_view>

#include "tests/unit/model/model_support.h"
#include "tests/unit/mutator.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench::test {
namespace {

using slipstack::test::damaged_inputs;
using slipstack::test::Mutator;

constexpr int kInputs = damaged_inputs(12'000);

// Tokens that a reader of TOML or of a model may fail on.
constexpr std::array<std::string_view, 36> kTokens{"\n",
                                                   "\r\n",
                                                   "=",
                                                   "[",
                                                   "]",
                                                   "[[",
                                                   "]]",
                                                   "[[effect]]\n",
                                                   "[target]\n",
                                                   "\"",
                                                   "'",
                                                   "\"\"\"",
                                                   "#",
                                                   ".",
                                                   ",",
                                                   "nan",
                                                   "inf",
                                                   "-inf",
                                                   "1e999",
                                                   "-1e30",
                                                   "0x1F",
                                                   "1979-05-27",
                                                   "true",
                                                   "{}",
                                                   "[]",
                                                   "\\n",
                                                   "\\u0000",
                                                   "\xFF",
                                                   "\xC0",
                                                   "\xEF\xBB\xBF",
                                                   "id = ",
                                                   "value = ",
                                                   "gain = []\n",
                                                   "\t",
                                                   "99999999999999999999",
                                                   "\"drift\""};

/// The violated invariant of a model on which the rest of the program relies; empty where all hold.
std::string broken_promise(const Model& model) {
  for (const Terms* terms : {&model.terms, &model.target_terms}) {
    if (terms->empty()) return "no effects";
    for (const Term& term : *terms) {
      if (term.effect == nullptr) return "no effect";
      const std::size_t gains = static_cast<std::size_t>(term.effect->gain_count);
      if (term.gains.size() != gains || term.lower.size() != gains || term.upper.size() != gains)
        return "gains";
      if (term.shapes.size() != term.effect->shapes.size()) return "shapes";
      if (!term.gain_standard_errors.empty() && term.gain_standard_errors.size() != gains)
        return "errors of gains";
      if (!term.shape_standard_errors.empty() && term.shape_standard_errors.size() != term.shapes.size()) {
        return "errors of shapes";
      }
      for (std::size_t i = 0; i < gains; ++i) {
        if (!(term.lower[i] <= term.gains[i] && term.gains[i] <= term.upper[i])) return "gain out of bounds";
      }
      for (const double shape : term.shapes) {
        if (!std::isfinite(shape)) return "shape";
      }
    }
  }
  static_cast<void>(target_hash(model));
  return {};
}

std::string broken_message(const std::string& message, const std::string& path) {
  if (!message.starts_with(path + ":")) return "does not begin with the file";
  for (const char c : message) {
    if (static_cast<unsigned char>(c) < 0x20) return "more than one line";
  }
  if (message.size() > path.size() + 1000) return "too long";
  return {};
}

// Ten thousand damaged files: each is read as a model that satisfies the invariants, or gives an error of one
// line.
TEST(ModelMutation, GivesAModelOrOneLine) {
  const TemporaryFile file;
  std::mt19937_64 random(1);
  Model small;
  for (const char* id :
       {"inertia", "presliding_hysteresis", "direction_asymmetry", "force_ripple", "time_delay"}) {
    small.terms.push_back(random_term(*find_effect(id), random, 4, true));
    small.target_terms.push_back(random_term(*find_effect(id), random, 3, false));
  }
  const std::array<std::string, 2> texts{to_toml(small), to_toml(full_model(2))};
  for (const std::string& text : texts) ASSERT_EQ(refusal(file.write(text)), "");
  // Without its hash line, a file with changed numbers is a model of its own.
  std::string unhashed = texts[0];
  const std::size_t hash = unhashed.find("hash = ");
  unhashed.erase(hash, unhashed.find('\n', hash) - hash);
  ASSERT_EQ(refusal(file.write(unhashed)), "");

  Mutator mutator(20240612, kTokens);
  const std::string path = file.path().string();
  int read = 0;
  int refused = 0;
  for (int i = 0; i < kInputs; ++i) {
    const std::string text = mutator.mutated(i % 4 == 3 ? texts[1] : i % 4 == 2 ? texts[0] : unhashed);
    file.write(text);
    try {
      ASSERT_EQ(broken_promise(read_model(path)), "") << text;
      ++read;
    } catch (const InputError& error) {
      ASSERT_EQ(broken_message(error.what(), path), "") << error.what() << '\n' << text;
      ++refused;
    } catch (const std::exception& error) {
      FAIL() << error.what() << '\n' << text;
    }
  }
  EXPECT_GT(read, kInputs / 24);
  EXPECT_GT(refused, kInputs / 12 * 5);
}

}  // namespace
}  // namespace slipstack::workbench::test
