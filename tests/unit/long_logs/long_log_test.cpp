// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/long_log.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>
#include <vector>

#include "tests/unit/temporary_directory.h"

// A log that stays in its file has the content that read_log() returns.
namespace slipstack::workbench {
namespace {

constexpr std::size_t kRows = 100'003;  // several places at which reading can start, and some rows more

struct Fault {
  std::size_t row = kRows;
  std::string text;
};

std::filesystem::path written(const std::string& name, std::uint64_t seed, const Fault& fault = {},
                              const std::string& header = "# mass_kg: 3\n") {
  std::mt19937_64 random(seed);
  std::filesystem::path path = slipstack::test::directory_of_process() / name;
  std::ofstream file(path);
  file << header << "# magnet_pitch_m: 0.024\ntime_s,position_um,force_N,temperature_C\n";
  for (std::size_t i = 0; i < kRows; ++i) {
    if (i == fault.row) {
      file << fault.text;
      continue;
    }
    if (random() % 5000 == 0) file << "# a remark\r\n\n";
    const double t = static_cast<double>(i);
    const double x_um = std::round(4000.0 * std::sin(t * 0.0007));
    file << fmt::format("{:.4f},{:.1f},{:.3f},{}\n", t * 5e-4, x_um,
                        static_cast<double>(random() % 1000) * 1e-3, 20 + random() % 3);
  }
  return path;
}

void expect_same(const Log& chunk, const Log& whole, std::size_t first, std::size_t count) {
  ASSERT_EQ(chunk.position_m.size(), count);
  ASSERT_EQ(chunk.temperature_C.size(), count);
  EXPECT_EQ(chunk.sample_rate_Hz, whole.sample_rate_Hz);
  EXPECT_EQ(chunk.mass_kg, whole.mass_kg);
  EXPECT_EQ(chunk.encoder_resolution_m, whole.encoder_resolution_m);
  EXPECT_NEAR(chunk.start_time_s, whole.start_time_s + static_cast<double>(first) / whole.sample_rate_Hz,
              1e-4);
  for (std::size_t i = 0; i < count; ++i) {
    ASSERT_EQ(chunk.position_m[i], whole.position_m[first + i]) << first + i;
    ASSERT_EQ(chunk.force_N[i], whole.force_N[first + i]) << first + i;
    ASSERT_EQ(chunk.temperature_C[i], whole.temperature_C[first + i]) << first + i;
  }
}

TEST(LongLog, ChunksOfAFileAndOfMemoryAreThoseOfTheWholeLog) {
  const std::filesystem::path path = written("long.csv", 1);
  const Log whole = read_log(path);
  const LongLog in_file = LongLog::open(path, 0);
  const LongLog in_memory = LongLog::open(path);
  ASSERT_EQ(in_file.sample_count(), kRows);
  ASSERT_EQ(in_memory.sample_count(), kRows);
  EXPECT_TRUE(in_file.head().position_m.empty());
  EXPECT_EQ(in_file.head().notes, whole.notes);
  EXPECT_EQ(in_file.head().header, whole.header);
  EXPECT_DOUBLE_EQ(in_file.travel_m(), in_memory.travel_m());
  std::mt19937_64 random(2);
  for (int n = 0; n < 12; ++n) {
    const std::size_t first = random() % (kRows - 1);
    const std::size_t count = 1 + random() % (kRows - first);
    expect_same(in_file.chunk(first, count), whole, first, count);
    expect_same(in_memory.chunk(first, count), whole, first, count);
  }
  expect_same(in_file.chunk(0, kRows), whole, 0, kRows);
}

TEST(LongLog, ATransmittedSurveyReplacesReading) {
  const std::filesystem::path path = written("transmitted.csv", 7);
  const Log whole = read_log(path);
  const LongLog read = LongLog::open(path, 0);
  ASSERT_NE(read.survey(), nullptr);
  const LongLog transmitted = LongLog::open(path, survey_of(to_bytes(*read.survey())));
  EXPECT_EQ(transmitted.sample_count(), kRows);
  EXPECT_EQ(transmitted.travel_m(), read.travel_m());
  EXPECT_EQ(transmitted.head().notes, read.head().notes);
  EXPECT_EQ(transmitted.head().header, read.head().header);
  EXPECT_EQ(transmitted.head().magnet_pitch_m, read.head().magnet_pitch_m);
  ASSERT_EQ(transmitted.envelope().size(), read.envelope().size());
  EXPECT_EQ(transmitted.envelope().samples(), read.envelope().samples());
  for (std::size_t i = 0; i < read.envelope().size(); ++i) {
    ASSERT_EQ(transmitted.envelope()[i].first_m, read.envelope()[i].first_m);
    ASSERT_EQ(transmitted.envelope()[i].high_m, read.envelope()[i].high_m);
  }
  expect_same(transmitted.chunk(40'000, 50'000), whole, 40'000, 50'000);
  // Another file under the same name.
  std::ofstream(path, std::ios::app) << "50.1,1,1,20\n";
  EXPECT_THROW(LongLog::open(path, *read.survey()), InputError);
}

TEST(LongLog, TheEnvelopeContainsEverySample) {
  const std::filesystem::path path = written("envelope.csv", 3);
  const Log whole = read_log(path);
  const LongLog log = LongLog::open(path, 0);
  ASSERT_EQ(log.envelope().size(), (kRows + kEnvelopeSamples - 1) / kEnvelopeSamples);
  for (std::size_t i = 0; i < kRows; ++i) {
    const EnvelopePoint& point = log.envelope()[i / kEnvelopeSamples];
    ASSERT_LE(point.low_m, static_cast<float>(whole.position_m[i])) << i;
    ASSERT_GE(point.high_m, static_cast<float>(whole.position_m[i])) << i;
  }
}

TEST(LongLog, EnvelopePointsAreJoinedWhereTheyBecomeTooMany) {
  constexpr std::size_t kMost = 16;
  std::mt19937_64 random(8);
  std::vector<double> position_m;
  Envelope envelope(kMost);
  while (position_m.size() < 9 * kMost * kEnvelopeSamples) {
    std::vector<double> more(1 + random() % 700);
    for (double& x : more) x = static_cast<double>(random() % 1000) * 1e-4;
    envelope.take(more);
    position_m.insert(position_m.end(), more.begin(), more.end());
    const std::size_t samples = envelope.samples();
    ASSERT_LE(envelope.size(), kMost);
    ASSERT_EQ(envelope.size(), (position_m.size() + samples - 1) / samples);
    for (std::size_t i = 0; i < envelope.size(); ++i) {
      const auto from = position_m.begin() + static_cast<std::ptrdiff_t>(i * samples);
      const auto to =
          i + 1 < envelope.size() ? from + static_cast<std::ptrdiff_t>(samples) : position_m.end();
      const auto [low, high] = std::minmax_element(from, to);
      ASSERT_EQ(envelope[i].first_m, static_cast<float>(*from)) << i;
      ASSERT_EQ(envelope[i].low_m, static_cast<float>(*low)) << i;
      ASSERT_EQ(envelope[i].high_m, static_cast<float>(*high)) << i;
    }
  }
  EXPECT_EQ(envelope.samples(), 16 * kEnvelopeSamples);
}

TEST(LongLog, SeveralThreadsReadAtTheSameTime) {
  const std::filesystem::path path = written("threads.csv", 4);
  const Log whole = read_log(path);
  const LongLog log = LongLog::open(path, 0);
  std::vector<std::jthread> threads;
  threads.reserve(4);
  for (std::size_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t first = t * 1000; first + 20000 < kRows; first += 17011) {
        expect_same(log.chunk(first, 20000), whole, first, 20000);
      }
    });
  }
}

std::string refusal(const std::filesystem::path& path) {
  try {
    LongLog::open(path, 0);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(LongLog, FaultsFarIntoTheFileAreReportedWithTheirLine) {
  const std::string bad = refusal(written("bad.csv", 5, {70'000, "35.0,1,x,20\n"}));
  EXPECT_NE(bad.find("column force_N"), std::string::npos) << bad;
  const std::string gap = refusal(written("gap.csv", 5, {70'000, ""}));
  EXPECT_NE(gap.find("time_s"), std::string::npos) << gap;
  // A row is missing just where one chunk ends and the next begins.
  for (const std::size_t row : {std::size_t{32'767}, std::size_t{32'768}, std::size_t{65'536}}) {
    const std::string between = refusal(written("between.csv", 5, {row, ""}));
    EXPECT_NE(between.find("time_s"), std::string::npos) << row << between;
  }
}

TEST(LongLog, ALongLogWithoutMotionIsRefused) {
  const std::filesystem::path path = slipstack::test::directory_of_process() / "still.csv";
  {
    std::ofstream file(path);
    file << "time_s,position_m,force_N\n";
    for (int i = 0; i < 40'000; ++i) file << fmt::format("{:.3f},0.5,{}\n", i * 1e-3, i % 7);
  }
  EXPECT_NE(refusal(path).find("never moves"), std::string::npos) << refusal(path);
}

TEST(LongLog, AFileThatShrinksMeanwhileIsRefused) {
  const std::filesystem::path path = written("shrinks.csv", 6);
  const LongLog log = LongLog::open(path, 0);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_THROW(log.chunk(kRows - 1000, 1000), InputError);
}

}  // namespace
}  // namespace slipstack::workbench
