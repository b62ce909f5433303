// SPDX-License-Identifier: Apache-2.0
// Whole commissionings of a simulated axis: with power cuts, and where something fails. More axes:
// tests/bench/commission.
#include "workbench/commission/commission.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "tests/unit/commission/axes.h"
#include "tests/unit/temporary_directory.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

using slipstack::test::TemporaryDirectory;

constexpr std::uint64_t kSeed = 4;

struct PowerCut : std::runtime_error {
  using std::runtime_error::runtime_error;
};

CommissionResult run(const TemporaryDirectory& folder, LiveAxis& axis, const std::string& cut_at = "") {
  Progress progress([&](const std::string& stage, double) {
    if (stage == cut_at) throw PowerCut("power");
  });
  CommissionFolder of_axis(folder / "axis", "axis");
  return commission(axis, of_axis, progress);
}

void expect_compensated(const CommissionResult& result) {
  ASSERT_GE(result.trials.size(), 3U);
  EXPECT_EQ(result.trials[2].effect, "viscous");
  EXPECT_NEAR(result.mass_kg, 35.45, 4.0);
  const ModelTrial& mass = result.trials.front();
  const ModelTrial& best = result.trials[result.deployed];
  EXPECT_LT(spread_of(best.reversal_rms_m).mean, 0.3 * spread_of(mass.reversal_rms_m).mean);
  EXPECT_LT(spread_of(best.rms_m).mean, 0.4 * spread_of(mass.rms_m).mean);
  EXPECT_LT(best.prediction_rms_N, 0.4 * mass.prediction_rms_N);
  // An encoder of 1 um: less would need an explanation.
  EXPECT_GT(spread_of(best.rms_m).mean, 0.1e-6);
  EXPECT_LT(result.axis_s, 180.0);
  EXPECT_GT(result.axis_s, 60.0);
}

// Then the power fails before each of its stages in turn, and each time the command goes on behind the last
// finished one.
TEST(Commission, FromNothingToACompensatedAxisAlsoAcrossPowerCuts) {
  const TemporaryDirectory whole;
  const LockstepMachine machine{.axis = viscous_axis(kSeed), .seed = kSeed, .motor_reversed = true};
  const auto uncut = host_axis(machine);
  const CommissionResult result = run(whole, *uncut);
  expect_compensated(result);
  const Model deployed = read_controller_model(whole / "axis" / "deployed.toml");
  EXPECT_GE(deployed.target_terms.size(), 3U);
  for (const auto& entry : std::filesystem::directory_iterator(whole / "axis"))
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();

  const TemporaryDirectory folder;
  ASSERT_GE(result.stages.size(), 10U);
  for (const StageReport& stage : result.stages) {
    const auto axis = host_axis(machine);
    EXPECT_THROW(run(folder, *axis, stage.stage), PowerCut) << stage.stage;
    EXPECT_FALSE(std::filesystem::exists(folder / "axis" / "deployed.toml")) << stage.stage;
  }
  const auto axis = host_axis(machine);
  const CommissionResult resumed = run(folder, *axis);
  expect_compensated(resumed);
  EXPECT_NEAR(resumed.axis_s, result.axis_s, 0.2 * result.axis_s);
  // Once more: everything is there, and the axis only gets its model again.
  const auto again = host_axis(machine);
  expect_compensated(run(folder, *again));
  EXPECT_LT(again->used_s(), 10.0);
  EXPECT_EQ(read_controller_model(folder / "axis" / "deployed.toml").target_terms.size(),
            deployed.target_terms.size());
}

/// What was said when it stopped.
std::string reason(const TemporaryDirectory& folder, LiveAxis& axis) {
  try {
    run(folder, axis);
  } catch (const CommissionStopped& stopped) {
    return stopped.what();
  }
  return "";
}

// The firmware's own faults, at different times; each ends it with the motor off and the reason.
TEST(Commission, StopsAtAnyFaultWithTheMotorOff) {
  struct Injected {
    long tick;
    void (*happens)(PlantLink&);
    const char* expected;
  };
  const Injected faults[] = {
      {8'000, [](PlantLink& link) { link.encoder_valid = 0; }, ""},         // in the first push or pulse
      {60'000, [](PlantLink& link) { link.encoder_valid = 0; }, "7305h"},   // in the feedback
      {350'000, [](PlantLink& link) { link.encoder_valid = 0; }, "7305h"},  // in a look
      {350'000, [](PlantLink& link) { link.current_valid = 0; }, "5210h"},
      {350'000, [](PlantLink& link) { link.current_offset_A = 5.0F; }, "5210h"},
  };
  for (const Injected& fault : faults) {
    const TemporaryDirectory folder;
    PlantLink* link = nullptr;
    auto board = std::make_unique<DisturbedBoard>([&](PlantLink& of_board, long tick) {
      link = &of_board;
      if (tick == fault.tick) fault.happens(of_board);
    });
    const auto axis = lockstep_axis(std::move(board), {.axis = viscous_axis(kSeed), .seed = kSeed});
    const std::string why = reason(folder, *axis);
    EXPECT_NE(why, "") << fault.tick << fault.expected;
    EXPECT_NE(why.find(fault.expected), std::string::npos) << why;
    EXPECT_EQ(link->driving, 0U) << fault.tick;
    EXPECT_FALSE(std::filesystem::exists(folder / "axis" / "deployed.toml"));
  }
}

TEST(Commission, ABoardThatNoLongerAnswersIsSaidSo) {
  const TemporaryDirectory folder;
  auto board = std::make_unique<DisturbedBoard>([](PlantLink&, long tick) {
    if (tick > 100'000) throw sim::LoopError("the emulator ended in the middle of the run (status 1)");
  });
  const auto axis = lockstep_axis(std::move(board), {.axis = viscous_axis(kSeed), .seed = kSeed});
  EXPECT_THROW(run(folder, *axis), DriveLost);
}

TEST(Commission, AnObstacleIsFoundSlowlyAndWithLittleForce) {
  const TemporaryDirectory folder;
  const auto axis = host_axis({.axis = viscous_axis(kSeed), .seed = kSeed, .end_m = 0.3});
  const std::string why = reason(folder, *axis);
  EXPECT_NE(why.find("does not get through its travel of 400.0 mm"), std::string::npos) << why;
  // By the encoder, which gives way with the stop and the feedback by some tenths of a millimetre.
  EXPECT_TRUE(why.find("at 299.") != std::string::npos || why.find("at 300.") != std::string::npos) << why;
}

// Stops of an axis of which nobody has said where it ends, one of them earlier than the rail.
TEST(Commission, EndsThatNobodyKnowsAreFoundSlowlyAndWithLittleForce) {
  const TemporaryDirectory folder;
  const auto axis = host_axis({.axis = viscous_axis(kSeed), .seed = kSeed, .end_m = 0.3});
  Progress progress([&](const std::string& stage, double) {
    if (stage == "look_1") throw PowerCut("enough");
  });
  CommissionFolder of_axis(folder / "axis", "axis");
  EXPECT_THROW(commission(*axis, of_axis, progress, true), PowerCut);
  const auto& ends = of_axis.found("ends");
  EXPECT_NEAR(ends.at("low_m").get<double>(), 0.0, 0.5e-3);
  EXPECT_NEAR(ends.at("high_m").get<double>(), 0.3, 0.5e-3);
  EXPECT_FALSE(ends.at("low_switch").get<bool>());
  EXPECT_LT(ends.at("force_N").get<double>(), 100.0);
  EXPECT_TRUE(of_axis.done("travel"));
  EXPECT_LT(axis->used_s(), 90.0);
}

TEST(Commission, AnAxisThatCannotMoveIsNotPushedFurther) {
  const TemporaryDirectory folder;
  sim::Axis axis = viscous_axis(kSeed);
  axis.current_limit_A = 0.3;  // half of its 18 N are below breakaway
  const auto live = host_axis({.axis = axis, .seed = kSeed});
  const std::string why = reason(folder, *live);
  EXPECT_NE(why.find("moves the axis in neither direction"), std::string::npos) << why;
  EXPECT_LT(live->used_s(), 5.0);
}

}  // namespace
}  // namespace slipstack::workbench
