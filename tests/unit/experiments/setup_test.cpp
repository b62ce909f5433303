// SPDX-License-Identifier: Apache-2.0
// Set-up files: those that ship are sound, and what no axis can have is refused in one line.
#include <gtest/gtest.h>

#include <string>

#include "sim_host/experiments/free_response.h"
#include "sim_host/experiments/setup.h"
#include "sim_host/experiments/setup_files.h"

namespace slipstack::sim {
namespace {

std::string refusal(const std::string& text) {
  try {
    parse_setup(text, "mine.toml");
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

void expect_refused(const std::string& text, const std::string& where, const std::string& what) {
  const std::string said = refusal(text);
  EXPECT_TRUE(said.starts_with(where)) << said;
  EXPECT_NE(said.find(what), std::string::npos) << said;
  EXPECT_EQ(said.find('\n'), std::string::npos) << said;
}

TEST(ReadSetup, EveryOneThatShipsIsSound) {
  EXPECT_GE(setup_files().size(), 7U);
  for (const SetupFile& file : setup_files()) {
    const ExperimentSetup setup = read_setup(std::string(file.name));
    EXPECT_FALSE(setup.title.empty()) << file.name;
    EXPECT_NE(setup.is_axis(), setup.transducer.has_value()) << file.name;
  }
}

TEST(ReadSetup, HasTheNumbersOfThePapers) {
  const ExperimentSetup pick = read_setup("pick_and_place");
  EXPECT_EQ(pick.axis.mass_kg, 35.45);
  EXPECT_EQ(pick.sensors.encoder_resolution_m, 1e-6);
  EXPECT_EQ(pick.defaults.forces_N, (std::vector<double>{3.75, 6.75, 9.75, 12.75, 15.75}));
  const ExperimentSetup slideway = read_setup("slideway");
  EXPECT_EQ(slideway.axis.mass_kg, 1.143);
  EXPECT_EQ(slideway.axis.curve.saturation_N(), 4.75);
  EXPECT_EQ(slideway.sensors.encoder_resolution_m, 10e-9);
  const ExperimentSetup loaded = read_setup("slideway_loaded");
  EXPECT_EQ(loaded.axis.mass_kg, 1.143);
  EXPECT_EQ(loaded.axis.effects.payload_kg, 0.845);
  EXPECT_EQ(loaded.axis.curve.saturation_N(), 4.75);
  EXPECT_EQ(loaded.defaults.forces_N, slideway.defaults.forces_N);
  EXPECT_EQ(loaded.defaults.lowest_Hz, 120.0);
}

TEST(ReadSetup, RefusesWhatNoAxisCanHave) {
  const std::string slideway = "based_on = \"slideway\"\n";
  expect_refused(slideway + "mass_kg = -1.0", "mine.toml:2:", "must be above 0");
  expect_refused(slideway + "mass_kg = \"heavy\"", "mine.toml:2:", "not a finite number");
  expect_refused(slideway + "mass_kg = nan", "mine.toml:2:", "not a finite number");
  expect_refused(slideway + "[cable_chain]\nstiffness_N_per_m = -5.0", "mine.toml:3:", "at least 0");
  expect_refused(slideway + "weight = 3.0", "mine.toml:2:", "unknown key 'weight'");
  expect_refused(slideway + "[sensors]\nsample_rate_Hz = 0", "mine.toml:3:", "above 0");
  expect_refused(
      slideway + "[[friction]]\nkind = \"stretched\"\nlevel_N = 4.0\nlength_m = 1e-6\nexponent = 1.2",
      "mine.toml:2:", "not concave");
  expect_refused(
      slideway + "[[friction]]\nkind = \"points\"\ndisplacement_m = [1e-6, 2e-6, 3e-6]\nforce_N = [1, 2, 4]",
      "mine.toml:2:", "not concave");
  expect_refused(
      slideway + "[[friction]]\nkind = \"points\"\ndisplacement_m = [1e-6, 2e-6]\nforce_N = [1, 0.5]",
      "mine.toml:2:", "stiffness is negative");
  expect_refused(slideway + "[[friction]]\nkind = \"steep\"", "mine.toml:3:", "none of exponential");
  expect_refused(slideway + "[preload_map]\nkind = \"trend\"\ndepth = 0.8", "mine.toml:4:", "lower depth");
  expect_refused("title = \"x\"\nmass_kg = 1.0", "mine.toml:1:", "has no stroke_m");
  expect_refused("title = ", "mine.toml:1:", "not TOML");
  expect_refused("based_on = \"nothing\"", "nothing:", "neither a set-up file nor one of");
}

TEST(FreeResponse, TurnsWhereTheEnergyBalanceSaysOnEverySetup) {
  for (const SetupFile& file : setup_files()) {
    const ExperimentSetup setup = read_setup(std::string(file.name));
    if (!setup.is_axis() || setup.axis.effects.preload) continue;
    const FreeResponse found = run_free(setup, setup.defaults.release_m, 16);
    ASSERT_TRUE(found.exact) << file.name;
    ASSERT_EQ(found.turning_points.size(), 16U) << file.name;
    for (const TurningPoint& turn : found.turning_points) {
      EXPECT_NEAR(turn.position_m, turn.check_m, 1e-9 * setup.defaults.release_m) << file.name;
    }
    EXPECT_NEAR(found.imbalance_J, 0.0, 1e-9 * found.start_energy_J) << file.name;
    // It rings down, faster at first than later, and not to zero.
    const auto swing = [&](std::size_t i) {
      return std::abs(found.turning_points[i + 1].position_m - found.turning_points[i].position_m);
    };
    EXPECT_LT(swing(1) / swing(0), swing(13) / swing(12)) << file.name;
    EXPECT_GT(std::abs(found.turning_points.back().position_m), 1e-3 * setup.defaults.release_m) << file.name;
  }
}

// An effect too small to matter sends the response down the other path, which must end at the same places.
TEST(FreeResponse, IsTheSameByBothPaths) {
  const std::string base = "based_on = \"pick_and_place\"\nelements = 2000\n";
  const FreeResponse exact = run_free(parse_setup(base, "test"), 20e-6, 16);
  const FreeResponse smooth = run_free(parse_setup(base + "offset_N = 1e-12", "test"), 20e-6, 16);
  ASSERT_TRUE(exact.exact);
  ASSERT_FALSE(smooth.exact);
  ASSERT_EQ(smooth.turning_points.size(), exact.turning_points.size());
  for (std::size_t i = 0; i < exact.turning_points.size(); ++i) {
    EXPECT_NEAR(smooth.turning_points[i].position_m, exact.turning_points[i].position_m, 1e-4 * 20e-6) << i;
    EXPECT_NEAR(smooth.turning_points[i].check_m, smooth.turning_points[i].position_m, 1e-6 * 20e-6) << i;
    EXPECT_NEAR(smooth.turning_points[i].force_N, exact.turning_points[i].force_N, 1e-3 * 12.0) << i;
  }
}

// Work lost to a dashpot: swings end sooner than without; with enough of it there are none.
TEST(FreeResponse, DampsWithTheSetUpsOtherEffects) {
  const std::string base = "based_on = \"pick_and_place\"\n";
  const FreeResponse bare = run_free(parse_setup(base, "test"), 20e-6, 8);
  const FreeResponse damped =
      run_free(parse_setup(base + "[viscous]\ncoefficient_N_s_per_m = 500.0", "test"), 20e-6, 8);
  ASSERT_EQ(damped.turning_points.size(), 8U);
  for (std::size_t i = 1; i < 8; ++i) {
    EXPECT_LT(std::abs(damped.turning_points[i].position_m - damped.turning_points[i - 1].position_m),
              std::abs(bare.turning_points[i].position_m - bare.turning_points[i - 1].position_m));
  }
  const FreeResponse creeping =
      run_free(parse_setup(base + "[viscous]\ncoefficient_N_s_per_m = 1e6", "test"), 20e-6, 8);
  EXPECT_TRUE(creeping.turning_points.empty());
  EXPECT_LT(creeping.position_m.back(), 20e-6);
}

}  // namespace
}  // namespace slipstack::sim
