// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/record_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/unit/temporary_directory.h"
#include "workbench/log/log.h"

namespace slipstack::workbench {
namespace {

using slipstack::test::TemporaryDirectory;

// Two cycles of a second, a reversal in the middle of each; errors of 1 µm, and of 3 µm for 50 ms after it.
TEST(CycleErrors, IsThatOfEachCycleButTheFirst) {
  AxisRecord record;
  record.rate_Hz = 1000.0;
  for (int i = 0; i < 3007; ++i) {
    const int in_cycle = i % 1000;
    record.reference_m.push_back(1e-4 * (in_cycle <= 500 ? in_cycle : 1000 - in_cycle));
    const bool after = in_cycle >= 501 && in_cycle < 551;
    const bool next = i >= 1000 && in_cycle >= 1 && in_cycle < 51;  // the reversal between two cycles
    const double scale = i < 1000 ? 100.0 : 1.0;                    // of the first, which does not count
    record.error_m.push_back(scale * (after || next ? 3e-6 : 1e-6));
  }
  const CycleErrors error = cycle_errors(record, 1.0);
  ASSERT_EQ(error.rms_m.size(), 2U);
  ASSERT_EQ(error.reversal_rms_m.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(error.rms_m[i], std::sqrt((100.0 * 9.0 + 900.0) / 1000.0) * 1e-6, 1e-9);
    EXPECT_NEAR(error.reversal_rms_m[i], 3e-6, 1e-8);
  }
}

TEST(CycleErrors, ARestIsNoReversal) {
  AxisRecord record;
  record.rate_Hz = 1000.0;
  for (int i = 0; i < 2100; ++i) {
    record.reference_m.push_back(1e-4 * (std::min(i % 1000, 300) + 300 * (i / 1000)));
    record.error_m.push_back(1e-6);
  }
  const CycleErrors error = cycle_errors(record, 1.0);
  ASSERT_EQ(error.rms_m.size(), 1U);
  EXPECT_EQ(error.reversal_rms_m[0], 0.0);
}

TEST(RecordLog, IsALogThatTheWorkbenchReads) {
  const TemporaryDirectory folder;
  AxisRecord record;
  record.rate_Hz = 2000.0;
  for (int i = 0; i < 400; ++i) {
    record.position_m.push_back(1e-6 * std::round(2000.0 * std::sin(0.03 * i)));
    record.reference_m.push_back(1e-6 * std::round(2001.0 * std::sin(0.03 * i)));
    record.force_N.push_back(12.5 * std::cos(0.03 * i));
  }
  const Nameplate plate{1e-6, 60.0, 10.0, 0.4, 1.0, 0.024, 1e-4};
  std::ofstream(folder / "log.csv") << log_csv(record, plate);
  const Log log = read_log(folder / "log.csv");
  ASSERT_EQ(log.position_m.size(), 400U);
  EXPECT_EQ(log.encoder_resolution_m, 1e-6);
  EXPECT_EQ(log.motor_constant_N_per_A, 60.0);
  EXPECT_EQ(log.magnet_pitch_m, 0.024);
  EXPECT_NEAR(log.position_m[37], record.position_m[37], 1e-12);
  EXPECT_NEAR(log.force_N[37], record.force_N[37], 1e-6);
}

}  // namespace
}  // namespace slipstack::workbench
