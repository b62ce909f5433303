// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/golden/shared_data.h"
#include "workbench/base/axis_units.h"
#include "workbench/estimate/measurement/plausibility.h"

// Recorded logs are as they are declared, and are seen to be reversed when they are.
namespace slipstack::workbench {
namespace {

class InputWarnings : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { forget_axis(); }
  void TearDown() override { forget_axis(); }
};

TEST_P(InputWarnings, AreNoneOfARecordedLog) {
  const auto path = shared_file(GetParam());
  SKIP_WITHOUT(path);
  const std::vector<InputWarning> warnings = input_warnings(Measurement(read_log(path)));
  EXPECT_TRUE(warnings.empty()) << warnings.front().what;
}

TEST_P(InputWarnings, NameAForceOfTheWrongSign) {
  if (std::string(GetParam()).starts_with("odrive")) {
    GTEST_SKIP() << "cogging on a turn one way: the work of friction is within its error";
  }
  const auto path = shared_file(GetParam());
  SKIP_WITHOUT(path);
  Log log = read_log(path);
  for (double& force : log.force_N) force = -force;
  const std::vector<InputWarning> warnings = input_warnings(Measurement(std::move(log)));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].kind, "force_sign");
}

INSTANTIATE_TEST_SUITE_P(Recorded, InputWarnings,
                         testing::Values("emps/emps_estimation.csv", "tribometer/tribometer_loops.csv",
                                         "odrive_cogging/odrive_0p1rev.csv", "hidden_effect/blind_1.csv",
                                         "hidden_effect/blind_2.csv", "hidden_effect/blind_3.csv",
                                         "hidden_effect/blind_4.csv", "hidden_effect/blind_5.csv",
                                         "hidden_effect/blind_6.csv"));

}  // namespace
}  // namespace slipstack::workbench
