// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/log/log_support.h"
#include "tests/unit/log/mat_builder.h"

namespace slipstack::workbench::test {
namespace {

class ReadMatTest : public testing::Test {
 protected:
  ReadMatTest() {
    for (std::size_t i = 0; i < 500; ++i) {
      const auto n = static_cast<double>(i);
      time_s_.push_back(2.5 + n * 5e-4);
      position_m_.push_back(std::round(40.0 * std::sin(0.05 * n)) * 1e-6);
      force_N_.push_back(15.0 * std::cos(0.05 * n));
    }
  }

  void expect_usual(const Log& log) const {
    EXPECT_EQ(violated_guarantee(log), "");
    EXPECT_EQ(log.sample_rate_Hz, 2000.0);
    EXPECT_EQ(log.start_time_s, 2.5);
    EXPECT_EQ(log.position_m, position_m_);
    EXPECT_EQ(log.force_N, force_N_);
  }

  void expect_refused(const std::string& message) const {
    const std::string refused = refusal_of_file(path_);
    EXPECT_EQ(refused.substr(0, path_.string().size() + message.size()), path_.string() + message);
    EXPECT_EQ(broken_message(refused, path_.string()), "") << refused;
  }

  std::string bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  void write_usual(bool compressed = false) const {
    MatBuilder builder(path_, MAT_FT_MAT5, compressed);
    builder.add(MatBuilder::make("time_s", time_s_)).add(MatBuilder::make("position_m", position_m_));
    builder.add(MatBuilder::make("force_N", force_N_));
    builder.add(MatBuilder::make("mass_kg", std::vector<double>{35.45}));
    builder.add(MatBuilder::make("operator_name", "Hans"));
  }

  TemporaryDirectory directory_;
  std::filesystem::path path_ = directory_ / "log.csv";  // the content decides on the format, not the name
  std::vector<double> time_s_;
  std::vector<double> position_m_;
  std::vector<double> force_N_;
};

TEST_F(ReadMatTest, Variables) {
  for (const bool compressed : {false, true}) {
    write_usual(compressed);
    const Log log = read_log(path_);
    expect_usual(log);
    EXPECT_EQ(log.mass_kg, 35.45);
    EXPECT_EQ(log.header.at("operator_name"), "Hans");
    EXPECT_EQ(log.encoder_resolution_m, 1e-6);
  }
}

TEST_F(ReadMatTest, RowVectors) {
  MatBuilder(path_)
      .add(MatBuilder::make("time_s", time_s_, 500))
      .add(MatBuilder::make("position_m", position_m_, 500))
      .add(MatBuilder::make("force_N", force_N_, 500));
  expect_usual(read_log(path_));
}

TEST_F(ReadMatTest, FieldsOfOneStruct) {
  for (const bool compressed : {false, true}) {
    MatBuilder(path_, MAT_FT_MAT5, compressed)
        .add(MatBuilder::make("unrelated", time_s_))
        .add_struct("log", {MatBuilder::make("time_s", time_s_), MatBuilder::make("position_m", position_m_),
                            MatBuilder::make("force_N", force_N_),
                            MatBuilder::make("magnet_pitch_m", std::vector<double>{0.024})})
        .add(MatBuilder::make("mass_kg", std::vector<double>{2.0}));
    const Log log = read_log(path_);
    expect_usual(log);
    EXPECT_EQ(log.magnet_pitch_m, 0.024);
    EXPECT_EQ(log.mass_kg, 2.0);
    EXPECT_EQ(log.notes.front(), "left out, neither vector, number nor text: unrelated");
  }
}

TEST_F(ReadMatTest, IntegerAndSinglePrecision) {
  std::vector<std::int32_t> counts;
  std::vector<float> current_A;
  std::vector<float> time_s;
  for (std::size_t i = 0; i < time_s_.size(); ++i) {
    counts.push_back(static_cast<std::int32_t>(std::lround(position_m_[i] * 1e6)));
    current_A.push_back(static_cast<float>(force_N_[i]));
    time_s.push_back(static_cast<float>(time_s_[i]));
  }
  MatBuilder(path_)
      .add(MatBuilder::make("time_s", MAT_C_SINGLE, MAT_T_SINGLE, time_s))
      .add(MatBuilder::make("position_counts", MAT_C_INT32, MAT_T_INT32, counts))
      .add(MatBuilder::make("current_A", MAT_C_SINGLE, MAT_T_SINGLE, current_A))
      .add(MatBuilder::make("encoder_resolution_m", std::vector<double>{1e-6}))
      .add(MatBuilder::make("motor_constant_N_per_A", std::vector<double>{2.0}));
  const Log log = read_log(path_);
  EXPECT_EQ(log.sample_rate_Hz, 2000.0);
  EXPECT_EQ(log.position_m[17], counts[17] * 1e-6);
  EXPECT_EQ(log.force_N[17], 2.0 * static_cast<double>(current_A[17]));
}

TEST_F(ReadMatTest, UnknownVector) {
  MatBuilder(path_)
      .add(MatBuilder::make("time_s", time_s_))
      .add(MatBuilder::make("position_inch", position_m_))
      .add(MatBuilder::make("force_N", force_N_));
  expect_refused(": column 'position_inch': unknown unit 'inch'; ");
}

TEST_F(ReadMatTest, NothingOfALog) {
  MatBuilder(path_).add(MatBuilder::make("answer", std::vector<double>{42.0}));
  expect_refused(": column time_s is missing; ");
}

TEST_F(ReadMatTest, MatrixInPlaceOfAVector) {
  MatBuilder(path_)
      .add(MatBuilder::make("time_s", time_s_))
      .add(MatBuilder::make("position_m", position_m_, 2))
      .add(MatBuilder::make("force_N", force_N_));
  expect_refused(": a position column is missing; ");
}

TEST_F(ReadMatTest, NotFinite) {
  position_m_[99] = std::numeric_limits<double>::quiet_NaN();
  write_usual();
  expect_refused(": position_m(100) is nan; ");
}

TEST_F(ReadMatTest, UnequalLengths) {
  force_N_.pop_back();
  write_usual();
  expect_refused(": force_N has 499 samples, time_s has 500; ");
}

TEST_F(ReadMatTest, TimeThatRepeatsNamesTheSample) {
  time_s_[99] = time_s_[98];
  write_usual();
  expect_refused(": sample 100: column time_s: 2.549 repeats");
}

TEST_F(ReadMatTest, TwoStructsWithLogs) {
  MatBuilder(path_)
      .add_struct("a", {MatBuilder::make("time_s", time_s_)})
      .add_struct("b", {MatBuilder::make("time_s", time_s_)});
  expect_refused(": structs 'a' and 'b' both hold a log; ");
}

// Version 7.3 is HDF5, which matio writes too where its header is there to be built with.
class ReadMat73Test : public ReadMatTest {
 protected:
  void SetUp() override {
    MatBuilder(path_, MAT_FT_MAT73).add(MatBuilder::make("answer", std::vector<double>{42.0}));
    if (refusal_of_file(path_).find("libhdf5") != std::string::npos) GTEST_SKIP() << refusal_of_file(path_);
  }
};

TEST_F(ReadMat73Test, Variables) {
  for (const bool compressed : {false, true}) {
    {
      MatBuilder builder(path_, MAT_FT_MAT73, compressed);
      builder.add(MatBuilder::make("time_s", time_s_)).add(MatBuilder::make("position_m", position_m_, 500));
      builder.add(MatBuilder::make("force_N", force_N_)).add(MatBuilder::make("eye", time_s_, 2));
      builder.add(MatBuilder::make("mass_kg", std::vector<double>{35.45}));
      builder.add(MatBuilder::make("operator_name", "Hans"));
    }
    const Log log = read_log(path_);
    expect_usual(log);
    EXPECT_EQ(log.mass_kg, 35.45);
    EXPECT_EQ(log.header.at("operator_name"), "Hans");
    EXPECT_EQ(log.notes.front(), "left out, neither vector, number nor text: eye");
  }
}

TEST_F(ReadMat73Test, FieldsOfOneStruct) {
  MatBuilder(path_, MAT_FT_MAT73)
      .add(MatBuilder::make("unrelated", time_s_))
      .add_struct("log", {MatBuilder::make("time_s", time_s_), MatBuilder::make("position_m", position_m_),
                          MatBuilder::make("force_N", force_N_),
                          MatBuilder::make("magnet_pitch_m", std::vector<double>{0.024})});
  const Log log = read_log(path_);
  expect_usual(log);
  EXPECT_EQ(log.magnet_pitch_m, 0.024);
  EXPECT_EQ(log.notes.front(), "left out, neither vector, number nor text: unrelated");
}

TEST_F(ReadMat73Test, SinglePrecisionIsKnown) {
  const std::vector<float> time_s(time_s_.begin(), time_s_.end());
  MatBuilder(path_, MAT_FT_MAT73)
      .add(MatBuilder::make("time_s", MAT_C_SINGLE, MAT_T_SINGLE, time_s))
      .add(MatBuilder::make("position_m", position_m_))
      .add(MatBuilder::make("force_N", force_N_));
  EXPECT_EQ(read_log(path_).sample_rate_Hz, 2000.0);  // a double with these stamps would be uneven
}

TEST_F(ReadMat73Test, WhatIsNoLogIsRefused) {
  MatBuilder(path_, MAT_FT_MAT73).add(MatBuilder::make("answer", std::vector<double>{42.0}));
  expect_refused(": column time_s is missing; ");
  position_m_[99] = std::numeric_limits<double>::quiet_NaN();
  MatBuilder(path_, MAT_FT_MAT73)
      .add(MatBuilder::make("time_s", time_s_))
      .add(MatBuilder::make("position_m", position_m_))
      .add(MatBuilder::make("force_N", force_N_));
  expect_refused(": position_m(100) is nan; ");
}

// libhdf5 faults on some damaged files: that ends the process that reads, and is said in one line.
TEST_F(ReadMat73Test, DamageIsALogOrOneLine) {
  MatBuilder(path_, MAT_FT_MAT73)
      .add_struct("log", {MatBuilder::make("time_s", time_s_), MatBuilder::make("position_m", position_m_),
                          MatBuilder::make("force_N", force_N_)});
  const std::string whole = bytes();
  std::mt19937 random(73);
  for (int round = 0; round < 150; ++round) {
    std::string damaged = whole;
    if (round % 3 == 0) damaged.resize(128 + random() % (whole.size() - 128));
    // Most of the file is numbers; its structure is what is worth damaging.
    for (unsigned i = 0; i < 1 + random() % 8; ++i) {
      const std::size_t at = 512 + random() % std::min<std::size_t>(damaged.size(), 4096);
      if (at < damaged.size()) damaged[at] = static_cast<char>(random());
    }
    std::ofstream(path_, std::ios::binary) << damaged;
    const std::string refused = refusal_of_file(path_);
    if (!refused.empty()) {
      ASSERT_EQ(broken_message(refused, path_.string()), "") << refused;
    }
  }
}

TEST_F(ReadMatTest, Hdf5OfAnotherProgram) {
  std::ofstream(path_, std::ios::binary) << "\x89HDF\r\n\x1A\n" << std::string(1000, '\0');
  expect_refused(": is an HDF5 file, not one of MATLAB; save it with save(..., '-v7')");
}

// A file that was cut off at any length is never read as a shorter log.
TEST_F(ReadMatTest, CutOff) {
  for (const bool compressed : {false, true}) {
    write_usual(compressed);
    const std::string whole = bytes();
    ASSERT_EQ(refusal_of_mat(whole), "");
    int cut_between_variables = 0;
    for (std::size_t length = 1; length < whole.size(); ++length) {
      const std::string refused = refusal_of_mat(whole.substr(0, length));
      // Without the last two variables, mass and operator, it is still a whole log.
      if (refused.empty()) {
        ++cut_between_variables;
        continue;
      }
      ASSERT_EQ(broken_message(refused, "log.mat"), "")
          << length << " of " << whole.size() << ": " << refused;
      const bool says_so =
          refused.find("cut off") != std::string::npos || refused.find("missing") != std::string::npos;
      ASSERT_TRUE(says_so) << refused;
    }
    EXPECT_EQ(cut_between_variables, 2);
  }
}

// A changed byte of the numbers is found by zlib's checksum.
TEST_F(ReadMatTest, CompressedDamageIsNoticed) {
  write_usual(true);
  const std::string whole = bytes();
  std::size_t refused = 0;
  std::size_t tried = 0;
  for (std::size_t i = kMatHeaderSize; i < whole.size(); i += 3) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    ++tried;
    if (!refusal_of_mat(damaged).empty()) ++refused;
  }
  // A few bits of a deflate stream mean nothing (padding, the tag of a short element).
  EXPECT_GT(refused, tried * 98 / 100);
}

// A file in the other byte order, built element by element after the description of the format.
TEST_F(ReadMatTest, OtherByteOrder) {
  const auto u32 = [](std::uint32_t value) {
    std::string text;
    for (int shift = 24; shift >= 0; shift -= 8) text += static_cast<char>((value >> shift) & 0xFF);
    return text;
  };
  const auto padded = [](std::string text) { return text.append((8 - text.size() % 8) % 8, '\0'); };
  const auto variable = [&](const std::string& name, const std::vector<double>& values) {
    std::string numbers;
    for (const double value : values) {
      const auto bits = std::bit_cast<std::uint64_t>(value);
      numbers += u32(static_cast<std::uint32_t>(bits >> 32)) + u32(static_cast<std::uint32_t>(bits));
    }
    std::string array = u32(6) + u32(8) + u32(6) + u32(0);  // flags: class double
    array += u32(5) + u32(8) + u32(static_cast<std::uint32_t>(values.size())) + u32(1);
    array += u32(1) + u32(static_cast<std::uint32_t>(name.size())) + padded(name);
    array += u32(9) + u32(static_cast<std::uint32_t>(numbers.size())) + numbers;
    return u32(14) + u32(static_cast<std::uint32_t>(array.size())) + array;
  };
  std::string file = "MATLAB 5.0 MAT-file";
  file.resize(124, ' ');
  file += std::string("\1\0MI", 4);
  file += variable("time_s", time_s_) + variable("position_m", position_m_) + variable("force_N", force_N_);
  expect_usual(parse_mat(file));
}

// Announced sizes beyond the numbers present, from one too many to 2³¹ × 2³¹, allocate no memory.
TEST_F(ReadMatTest, AnnouncesMoreThanItHolds) {
  write_usual();
  const std::string whole = bytes();
  const std::size_t rows =
      128 + 8 + 16 + 8;  // header, tag of the variable, array flags, tag of the dimensions
  ASSERT_EQ(whole.substr(rows, 8), std::string("\xF4\x01\0\0\1\0\0\0", 8)) << "500 x 1";
  for (const std::string& wrong : {std::string("\xF5\x01\0\0", 4), std::string("\xF3\x01\0\0", 4),
                                   std::string("\xFF\xFF\xFF\x7F", 4), std::string("\xF4\x01\0\x80", 4)}) {
    std::string damaged = whole;
    damaged.replace(rows, 4, wrong);
    EXPECT_EQ(refusal_of_mat(damaged),
              "log.mat: the MAT file is damaged: the size of variable 'time_s' does not fit its numbers; "
              "copy or save "
              "it again");
  }
  std::string damaged = whole;
  damaged.replace(rows, 8, "\xFF\xFF\xFF\x7F\xFF\xFF\xFF\x7F");
  EXPECT_TRUE(refusal_of_mat(damaged).starts_with("log.mat: column time_s is missing; "));
}

TEST_F(ReadMatTest, SparseFileOfTwoGibibytes) {
  write_usual();
  std::filesystem::resize_file(path_, std::uintmax_t{2} << 30);
  expect_refused(": the MAT file is damaged: a variable has no type; ");
}

}  // namespace
}  // namespace slipstack::workbench::test
