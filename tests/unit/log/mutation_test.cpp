// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "tests/unit/log/log_support.h"
#include "tests/unit/log/mat_builder.h"
#include "tests/unit/mutator.h"

namespace slipstack::workbench::test {
namespace {

using slipstack::test::damaged_inputs;
using slipstack::test::Mutator;

constexpr int kInputs = damaged_inputs(10'000);

constexpr const char* kSource = "log.csv";

// Tokens that a reader of logs may fail on.
constexpr std::array<std::string_view, 30> kTokens{",",
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

std::vector<std::string> corpus() {
  std::string counts =
      "# encoder_resolution_m: 1e-7\n# motor_constant_N_per_A: 71.5\ntime_s,position_counts,current_A\n";
  std::string wide =
      "# mass_kg: 0\r\n# sampling: uniform\r\ntime_s,position_um,force_mN,velocity_mps,temperature_C\r\n";
  std::string irregular = "# sampling: irregular\n# note\ntime_s,position_mm,force_N\n";
  for (int i = 0; i < 150; ++i) {
    const std::string n = std::to_string(i);
    counts += n + "e-3," + std::to_string(i * i % 97) + "," + n + "\n";
    wide += n + "," + std::to_string(i % 13) + ", -" + n + ".5,0.1,2" + n + "\r\n";
    irregular += std::to_string(i * 3 + i % 2) + "," + n + ".25," + n + "\n";
  }
  return {"# mass_kg: 35.45\ntime_s,position_m,force_N\n" + usual_rows(105), counts, wide, irregular};
}

// Damaged logs: each gives a Log that fulfils the guarantees of log.h or an error message of one line.
class CsvMutation : public testing::TestWithParam<std::size_t> {};

TEST_P(CsvMutation, GivesALogOrOneLine) {
  const std::string original = corpus()[GetParam()];
  ASSERT_EQ(refusal(original), "");
  Mutator mutator(20240611 + GetParam(), kTokens);
  int read = 0;
  int refused = 0;
  for (int i = 0; i < kInputs; ++i) {
    const std::string text = mutator.mutated(original);
    try {
      const Log log = parse_text(text);
      ASSERT_EQ(violated_guarantee(log), "") << text;
      ++read;
    } catch (const InputError& error) {
      ASSERT_EQ(broken_message(error.what(), kSource), "") << error.what() << "\n" << text;
      ++refused;
    }
  }
  // Both outcomes must occur often, or the damage is too mild or too heavy to test anything.
  EXPECT_GT(read, kInputs / 40);
  EXPECT_GT(refused, kInputs / 4);
}

INSTANTIATE_TEST_SUITE_P(EachText, CsvMutation, testing::Range(std::size_t{0}, corpus().size()));

std::string mat_bytes(const TemporaryDirectory& directory, bool compressed, bool as_struct) {
  std::vector<double> time_s;
  std::vector<double> position_m;
  std::vector<float> force_N;
  for (int i = 0; i < 120; ++i) {
    time_s.push_back(i * 1e-3);
    position_m.push_back((i * i % 41) * 1e-6);
    force_N.push_back(static_cast<float>(i % 17));
  }
  {
    MatBuilder builder(directory / "seed.mat", MAT_FT_MAT5, compressed);
    const std::vector<matvar_t*> variables{
        MatBuilder::make("time_s", time_s), MatBuilder::make("position_m", position_m),
        MatBuilder::make("force_N", MAT_C_SINGLE, MAT_T_SINGLE, force_N),
        MatBuilder::make("mass_kg", std::vector<double>{3.0}), MatBuilder::make("site", "hall 3")};
    if (as_struct) {
      builder.add_struct("log", variables);
    } else {
      for (matvar_t* variable : variables) builder.add(variable);
    }
  }
  std::ifstream file(directory / "seed.mat", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The same for damaged MAT-files.
class MatMutation : public testing::TestWithParam<std::tuple<bool, bool>> {};

TEST_P(MatMutation, GivesALogOrOneLine) {
  const auto [compressed, as_struct] = GetParam();
  const TemporaryDirectory directory;
  const std::string original = mat_bytes(directory, compressed, as_struct);
  std::mt19937_64 random(5U + (compressed ? 1U : 0U) + (as_struct ? 2U : 0U));
  int read = 0;
  int refused = 0;
  for (int i = 0; i < kInputs; ++i) {
    std::string bytes = original;
    for (std::size_t k = 0; k < 1 + random() % 5; ++k) {
      // Most changes are made to tags, sizes and names, which determine the structure.
      const std::size_t reach = random() % 4 == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), 500);
      bytes[random() % reach] = static_cast<char>(random() % 3 == 0 ? random() % 256 : random() % 20);
    }
    if (random() % 8 == 0) bytes.resize(random() % bytes.size());
    try {
      ASSERT_EQ(violated_guarantee(parse_mat(bytes)), "");
      ++read;
    } catch (const InputError& error) {
      ASSERT_EQ(broken_message(error.what(), "log.mat"), "") << error.what();
      ++refused;
    }
  }
  EXPECT_GT(read, kInputs / 100);
  EXPECT_GT(refused, kInputs / 2);
}

INSTANTIATE_TEST_SUITE_P(EachForm, MatMutation, testing::Combine(testing::Bool(), testing::Bool()));

}  // namespace
}  // namespace slipstack::workbench::test
