// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/golden/shared_data.h"
#include "workbench/base/axis_units.h"

// A bare motor that cogs: one slow turn, almost no reversal (MIT licence, gchenfc/ODrive).
namespace slipstack::workbench {
namespace {

/// Its axis is rotary, those of the other tests are linear.
class CoggingMotor : public testing::Test {
 protected:
  void SetUp() override { forget_axis(); }
  void TearDown() override { forget_axis(); }
};

TEST_F(CoggingMotor, CoggingIsNamedAndNothingThatTheLogDoesNotSupport) {
  const auto path = shared_file("odrive_cogging/odrive_0p1rev.csv");
  SKIP_WITHOUT(path);
  Measurement measurement = measured(path);
  const Diagnosis diagnosis =
      diagnose(measurement, {.baseline = {"inertia", "presliding_hysteresis"}, .start = {}, .progress = {}});
  ASSERT_GE(diagnosis.steps.size(), 2u);
  EXPECT_EQ(diagnosis.steps[1].effect, "force_ripple");
  // Seven periods a turn, as its author measured: 2 pi / 7 = 0.8976 rad.
  EXPECT_NEAR(find_term(diagnosis.explained.terms, "force_ripple")->shapes[0], 0.8976, 0.006);
  for (std::size_t i = 1; i < diagnosis.steps.size(); ++i) {
    EXPECT_LT(diagnosis.steps[i].criterion_difference, 0.0) << diagnosis.steps[i].effect;
    // With hardly a reversal the directions are not told apart.
    EXPECT_NE(diagnosis.steps[i].effect, "direction_asymmetry");
  }
}

}  // namespace
}  // namespace slipstack::workbench
