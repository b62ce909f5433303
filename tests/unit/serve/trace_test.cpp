// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/views/trace.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

namespace slipstack::workbench {
namespace {

constexpr double kRate_Hz = 1000.0;

struct Written {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / fmt::format("slipstack-trace-{}.csv", ::getpid());
  std::vector<double> force_N;
  explicit Written(std::size_t samples) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0.0, 1.0);
    std::ofstream file(path);
    file << "time_s,position_m,force_N\n";
    for (std::size_t i = 0; i < samples; ++i) {
      const double t = static_cast<double>(i) / kRate_Hz;
      force_N.push_back(std::round(1e4 * (std::sin(t) + noise(random))) / 1e4);
      file << fmt::format("{:.3f},{:.6f},{:.4f}\n", t, 0.1 * std::sin(0.3 * t), force_N.back());
    }
  }
  ~Written() { std::filesystem::remove(path); }
};

// Whatever is asked for: every sample lies within the extremes of its point, every extreme is a sample of its
// point, and there are not more points than asked for.
TEST(Trace, ExtremesAreThoseOfTheSamples) {
  const Written log(50'003);
  const Trace trace(LongLog::open(log.path));
  ASSERT_EQ(trace.samples(), log.force_N.size());
  std::mt19937 random(5);
  for (int round = 0; round < 300; ++round) {
    const double last_s = static_cast<double>(log.force_N.size()) / kRate_Hz;
    double from_s = last_s * std::generate_canonical<double, 32>(random);
    double to_s = last_s * std::generate_canonical<double, 32>(random);
    if (from_s > to_s) std::swap(from_s, to_s);
    const std::size_t points = 16 + random() % 2000;
    const Trace::Picture picture = trace.picture(Trace::Signal::force, from_s, to_s, points);
    ASSERT_LE(picture.points.size(), points + 2);
    if (to_s - from_s < static_cast<double>(points - 2) / kRate_Hz) {
      ASSERT_EQ(picture.samples_per_point, 1U);
    }
    const auto begin = static_cast<std::size_t>(std::llround(picture.first_s * kRate_Hz));
    ASSERT_LE(begin, static_cast<std::size_t>(from_s * kRate_Hz) + 1);
    ASSERT_GE(begin + picture.points.size() * picture.samples_per_point,
              static_cast<std::size_t>(to_s * kRate_Hz));
    for (std::size_t p = 0; p < picture.points.size(); ++p) {
      const std::size_t first = begin + p * picture.samples_per_point;
      const std::size_t end = std::min(first + picture.samples_per_point, log.force_N.size());
      const auto [low, high] = std::minmax_element(log.force_N.begin() + static_cast<std::ptrdiff_t>(first),
                                                   log.force_N.begin() + static_cast<std::ptrdiff_t>(end));
      ASSERT_EQ(picture.points[p].low, static_cast<float>(*low));
      ASSERT_EQ(picture.points[p].high, static_cast<float>(*high));
    }
  }
}

}  // namespace
}  // namespace slipstack::workbench
