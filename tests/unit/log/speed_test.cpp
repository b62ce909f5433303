// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include "tests/unit/log/log_support.h"

namespace slipstack::workbench::test {
namespace {

// 10⁶ rows of three columns took 0.10 s on one core of the developers' machine. Ten times that is more than a
// busy machine explains.
TEST(ReadSpeed, AMillionRows) {
#ifdef SLIPSTACK_SANITIZED
  GTEST_SKIP() << "SKIP: times say nothing under a sanitizer";
#endif
  std::string text = "# encoder_resolution_m: 1e-7\ntime_s,position_m,force_N\n";
  for (std::size_t i = 0; i < 1'000'000; ++i) {
    const auto n = static_cast<double>(i);
    char line[96];
    std::snprintf(line, sizeof line, "%.6f,%.9f,%.5f\n", n * 5e-4,
                  std::round(1e5 * std::sin(n * 1e-3)) * 1e-7, 10.0 * std::cos(n * 1e-3));
    text += line;
  }
  const TemporaryDirectory directory;
  const auto path = directory.write("big.csv", text);
  const auto start = std::chrono::steady_clock::now();
  const Log log = read_log(path);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(log.position_m.size(), 1'000'000U);
  EXPECT_EQ(log.sample_rate_Hz, 2000.0);
  RecordProperty("seconds", std::to_string(elapsed.count()));
  std::printf("10^6 rows, %.1f MB: %.3f s\n", static_cast<double>(text.size()) * 1e-6, elapsed.count());
  EXPECT_LT(elapsed.count(), 1.0);
}

}  // namespace
}  // namespace slipstack::workbench::test
