// SPDX-License-Identifier: Apache-2.0
// A planned motion on the axis behind a node: what it is compared with, how it is run, and what stops it.
#include "workbench/serve/live/plan_on_axis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/serve/recorded_log.h"
#include "workbench/base/cancel.h"
#include "workbench/can/drive/drive_access.h"
#include "workbench/serve/live/simulated_axis.h"

namespace slipstack::workbench {
namespace {

const Show kNoProgress = [](const std::string&, double) {};
constexpr double kAmplitude_m = 0.02;
constexpr double kFrequency_Hz = 0.5;
constexpr double kSeconds = 4.0;
constexpr double kAside_m = 0.01;  // of where the axis stands, the plan begins

struct Bench {
  SimulatedController controller{SimulatedAxis{11, "viscous", 5.0, 20.0}};
  std::unique_ptr<CanLink> cable = controller.connect(SimulatedController::Wait::as_fast_as_possible);
  SdoClient drive{*cable, 5};

  double now_m() { return static_cast<std::int32_t>(drive.read(0x6063, 0)) * drive.read_real(0x2000, 1); }

  /// From standstill to standstill, beside where the axis is.
  DriveMotion plan() {
    DriveMotion motion;
    motion.rate_Hz = 1000.0;
    const double begin_m = now_m() + kAside_m;
    const double omega = 2.0 * std::numbers::pi * kFrequency_Hz;
    for (int i = 0; i <= static_cast<int>(kSeconds * motion.rate_Hz); ++i)
      motion.position_m.push_back(begin_m + kAmplitude_m * (1.0 - std::cos(omega * i / motion.rate_Hz)));
    motion.velocity_mps = kAmplitude_m * omega;
    motion.acceleration_mps2 = kAmplitude_m * omega * omega;
    motion.force_N = 20.0;
    motion.log_low_m = 0.0;
    motion.log_high_m = 1.0;
    motion.places_known = true;
    return motion;
  }

  std::vector<std::uint32_t> objects() {
    std::vector<std::uint32_t> values;
    for (const auto& [index, sub] : std::vector<std::pair<std::uint16_t, std::uint8_t>>{{0x1005, 0},
                                                                                        {0x1006, 0},
                                                                                        {0x1402, 1},
                                                                                        {0x1602, 0},
                                                                                        {0x1800, 1},
                                                                                        {0x1800, 2},
                                                                                        {0x1802, 1},
                                                                                        {0x1803, 1},
                                                                                        {0x1A00, 0},
                                                                                        {0x1A00, 1},
                                                                                        {0x1A03, 1},
                                                                                        {0x2403, 0},
                                                                                        {0x6060, 0},
                                                                                        {0x60C2, 1},
                                                                                        {0x60C2, 2}})
      values.push_back(drive.read(index, sub));
    return values;
  }

  std::string refusal(const DriveMotion& motion) {
    const double before_m = now_m();
    try {
      static_cast<void>(run_plan_on(drive, motion, {}, kNoProgress));
    } catch (const UsageError& error) {
      EXPECT_NEAR(now_m(), before_m, 1e-5) << "it was moved all the same";
      EXPECT_FALSE(is_enabled(drive));
      EXPECT_EQ(check_plan_on(drive, motion).refused.empty(), false);
      return error.what();
    }
    return "none";
  }
};

TEST(PlanSampling, IsThatOfTheLogsWhereTheBusCanCarryIt) {
  for (const auto& [rate_Hz, expected_Hz, period_ms] :
       std::vector<std::tuple<double, double, int>>{{1000.0, 1000.0, 1},
                                                    {500.0, 500.0, 2},
                                                    {200.0, 200.0, 1},
                                                    {100.0, 100.0, 2},
                                                    {2000.0, 1000.0, 1},
                                                    {300.0, 1000.0, 1},
                                                    {1.0, 1000.0, 1}}) {
    EXPECT_NEAR(sampling_for(rate_Hz).rate_Hz(), expected_Hz, 1e-9) << rate_Hz;
    EXPECT_EQ(sampling_for(rate_Hz).period_ms, period_ms) << rate_Hz;
  }
}

TEST(PlanOnAxis, IsFollowedRecordedAndEverythingIsLeftAsItWas) {
  for (const double rate_Hz : {1000.0, 100.0}) {
    Bench bench;
    const DriveMotion plan = bench.plan();
    const auto before = bench.objects();
    double fraction = 0.0;
    const Recording recording =
        run_plan_on(bench.drive, plan, sampling_for(rate_Hz),
                    [&](const std::string&, double now) { fraction = std::max(fraction, now); });
    EXPECT_GT(fraction, 0.9) << "progress is told";
    EXPECT_EQ(bench.objects(), before);
    EXPECT_FALSE(is_enabled(bench.drive));
    const Log log = test::read_recorded(recording.log);
    EXPECT_NEAR(log.sample_rate_Hz, rate_Hz, 1e-6);
    EXPECT_EQ(recording.lost, 0U);
    ASSERT_NEAR(static_cast<double>(log.position_m.size()) / rate_Hz, kSeconds, 0.1);
    double worst_m = 0.0;
    for (std::size_t i = 0; i < log.position_m.size(); ++i) {
      const auto at =
          std::min(static_cast<std::size_t>(std::lround(static_cast<double>(i) / rate_Hz * plan.rate_Hz)),
                   plan.position_m.size() - 1);
      worst_m = std::max(worst_m, std::fabs(log.position_m[i] - plan.position_m[at]));
    }
    // Two periods of 1 or 2 ms at 63 mm/s, and what the axis does not follow without a friction model.
    EXPECT_LT(worst_m, 1e-3);
    EXPECT_GT(worst_m, 1e-9);
    double largest_N = 0.0;
    for (const double force_N : log.force_N) largest_N = std::max(largest_N, std::fabs(force_N));
    EXPECT_GT(largest_N, 1.0) << "friction";
  }
}

TEST(PlanOnAxis, OneThatLeavesWhatTheAxisMayDoIsNotRun) {
  Bench bench;
  DriveMotion plan = bench.plan();
  plan.log_high_m = plan.high_m() - 1e-3;
  EXPECT_NE(bench.refusal(plan).find("highest position leaves what the axis may do (where the logs were"),
            std::string::npos)
      << bench.refusal(plan);
  plan = bench.plan();
  plan.velocity_mps = 1.01 * bench.drive.read_real(0x2000, 0x0B);
  EXPECT_NE(bench.refusal(plan).find("velocity leaves"), std::string::npos);
  plan = bench.plan();
  plan.acceleration_mps2 = 1.01 * bench.drive.read_real(0x2000, 0x0C);
  EXPECT_NE(bench.refusal(plan).find("acceleration leaves"), std::string::npos);
  plan = bench.plan();
  plan.force_N = 1.01 * bench.drive.read_real(0x2000, 9) * bench.drive.read_real(0x2000, 3);
  EXPECT_NE(bench.refusal(plan).find("force leaves"), std::string::npos);
  // The drive's own limits of the place count where it has some, wherever the logs were.
  plan = bench.plan();
  plan.log_low_m = plan.log_high_m = 0.0;
  const double resolution_m = bench.drive.read_real(0x2000, 1);
  const auto counts = [&](double position_m) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(position_m / resolution_m)));
  };
  bench.drive.write(0x607D, 1, counts(plan.low_m() - 0.05), 4);
  bench.drive.write(0x607D, 2, counts(plan.high_m() + 0.05), 4);
  EXPECT_EQ(check_plan_on(bench.drive, plan).refused, "");
  bench.drive.write(0x607D, 2, counts(plan.high_m() - 1e-3), 4);
  EXPECT_NE(bench.refusal(plan).find("highest position leaves what the axis may do (software limits, 607Dh)"),
            std::string::npos);
}

TEST(PlanOnAxis, ADriveThatIsInUseOrLostItsPlaceIsNotMoved) {
  Bench bench;
  DriveMotion plan = bench.plan();
  plan.places_known = false;
  EXPECT_EQ(check_plan_on(bench.drive, plan).refused, "") << "its encoder is absolute";
  bench.drive.write(0x2012, 1, 0, 1);  // an incremental one now, and not homed
  store_parameters(bench.drive);
  bench.drive.nmt(0x81);
  bench.drive.await_node();
  EXPECT_NE(bench.refusal(plan).find("does not know its positions"), std::string::npos);
  plan.places_known = true;
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) bench.drive.write(0x6040, 0, word, 2);
  for (int i = 0; i < 1000 && !is_enabled(bench.drive); ++i) {
  }
  EXPECT_NE(check_plan_on(bench.drive, plan).refused.find("enabled by another master"), std::string::npos);
  bench.drive.write(0x6040, 0, 0, 2);
}

TEST(PlanOnAxis, CancelledOnTheWayTheAxisStopsAndIsLeft) {
  Bench bench;
  const DriveMotion plan = bench.plan();
  const auto before = bench.objects();
  EXPECT_THROW(static_cast<void>(run_plan_on(bench.drive, plan, {},
                                             [](const std::string&, double fraction) {
                                               if (fraction > 0.3) throw Cancelled();
                                             })),
               Cancelled);
  EXPECT_EQ(bench.objects(), before);
  EXPECT_FALSE(is_enabled(bench.drive));
  const double here_m = bench.now_m();
  CanFrame frame;
  for (int i = 0; i < 100; ++i) static_cast<void>(bench.cable->receive(frame, 1));
  EXPECT_NEAR(bench.now_m(), here_m, 1e-5) << "it is at rest";
}

TEST(PlanOnAxis, AFaultOnTheWayIsSaidInPlainWords) {
  Bench bench;
  bench.drive.write_real(0x2000, 0x0F, 1e-5);  // a following error that any motion without a model has
  bench.drive.write(0x2140, 3, bench.drive.read(0x2140, 1), 4);
  std::string said;
  try {
    static_cast<void>(run_plan_on(bench.drive, bench.plan(), {}, kNoProgress));
  } catch (const UsageError& error) {
    said = error.what();
  }
  EXPECT_FALSE(said.empty());
  EXPECT_FALSE(is_enabled(bench.drive));
  EXPECT_NE(check_plan_on(bench.drive, bench.plan()).refused.find("8611h, the axis does not follow"),
            std::string::npos)
      << said;
}

}  // namespace
}  // namespace slipstack::workbench
