// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "tests/unit/log/log_support.h"

namespace slipstack::workbench::test {
namespace {

struct SharedLog {
  const char* file;
  std::size_t samples;
  double rate_Hz;
  double start_s;
  double step_m;
};

class SharedLogTest : public testing::TestWithParam<SharedLog> {};

TEST_P(SharedLogTest, IsRead) {
  const SharedLog& expected = GetParam();
  const std::filesystem::path path = shared_data() / expected.file;
  if (shared_data().empty() || !std::filesystem::exists(path))
    GTEST_SKIP() << "SKIP: no shared measurements here";
  const Log log = read_log(path);
  EXPECT_EQ(violated_guarantee(log), "");
  EXPECT_EQ(log.position_m.size(), expected.samples);
  EXPECT_EQ(log.sample_rate_Hz, expected.rate_Hz);
  EXPECT_EQ(log.start_time_s, expected.start_s);
  ASSERT_TRUE(log.encoder_resolution_m);
  EXPECT_DOUBLE_EQ(*log.encoder_resolution_m, expected.step_m);
}

// The encoder step of the header is also found from the positions alone.
TEST_P(SharedLogTest, ShowsItsEncoderStep) {
  const std::filesystem::path path = shared_data() / GetParam().file;
  if (shared_data().empty() || !std::filesystem::exists(path))
    GTEST_SKIP() << "SKIP: no shared measurements here";
  std::ifstream file(path);
  std::ostringstream text;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("# encoder_resolution_m")) text << line << '\n';
  }
  const Log log = parse_text(text.str());
  ASSERT_TRUE(log.encoder_resolution_m);
  EXPECT_DOUBLE_EQ(*log.encoder_resolution_m, GetParam().step_m);
}

INSTANTIATE_TEST_SUITE_P(All, SharedLogTest,
                         testing::Values(SharedLog{"emps/emps_estimation.csv", 24'841, 1000.0, 0.0, 5e-8},
                                         SharedLog{"tribometer/tribometer_loops.csv", 19'600, 200.0, 12.004,
                                                   1e-7},
                                         SharedLog{"hidden_effect/blind_1.csv", 158'863, 2000.0, 0.0, 1e-7},
                                         SharedLog{"hidden_effect/blind_2.csv", 100'229, 2000.0, 0.0, 1e-7},
                                         SharedLog{"hidden_effect/blind_3.csv", 101'103, 2000.0, 0.0, 1e-7},
                                         SharedLog{"hidden_effect/blind_4.csv", 160'842, 2000.0, 0.0, 5e-7},
                                         SharedLog{"hidden_effect/blind_5.csv", 152'716, 2000.0, 0.0, 1e-7},
                                         SharedLog{"hidden_effect/blind_6.csv", 83'025, 2000.0, 0.0, 2e-7}),
                         [](const auto& param) {
                           std::string name = std::filesystem::path(param.param.file).stem().string();
                           return name;
                         });

}  // namespace
}  // namespace slipstack::workbench::test
