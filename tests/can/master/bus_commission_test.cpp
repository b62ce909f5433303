// SPDX-License-Identifier: Apache-2.0
// `slipstack commission` over a bus: the firmware's node around a simulated axis, whose time passes while the
// master waits.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "firmware/canopen/objects/object_table.h"
#include "firmware/effects/model_hash.h"
#include "sim_host/log/draw.h"
#include "tests/can/master/desk.h"
#include "tests/unit/temporary_directory.h"
#include "workbench/can/drive/can_axis.h"
#include "workbench/commission/commission.h"
#include "workbench/commission/drive_memory.h"
#include "workbench/model/model.h"

namespace slipstack::workbench {
namespace {

using slipstack::test::TemporaryDirectory;

constexpr std::uint64_t kSeed = 4;

sim::Bench viscous_bench() {
  sim::Bench bench = sim::draw_bench(sim::Setup::kPickAndPlace, kSeed);
  sim::add_effects(bench.axis, {sim::EffectId::kViscous}, sim::draw_programme(bench, kSeed), bench.rate_Hz,
                   6.0, kSeed);
  return bench;
}

struct PowerCut : std::runtime_error {
  using std::runtime_error::runtime_error;
};

CommissionResult run(Desk& desk, const TemporaryDirectory& folder, const BusAxis& told,
                     const std::string& cut_at = "") {
  Progress progress([&](const std::string& stage, double) {
    if (stage == cut_at) throw PowerCut("power");
  });
  CommissionFolder of_axis(folder / "axis", drive_title(*desk.client));
  const auto axis = can_axis(*desk.client, told, memory_in(of_axis));
  return commission(*axis, of_axis, progress);
}

std::string text_of(const CommissionResult& result) {
  std::string text;
  for (const StageReport& stage : result.stages) text += stage.stage + ": " + stage.found + "\n";
  return text;
}

/// Every object that is stored as a parameter, and the model that runs.
std::vector<std::uint32_t> held_by(Desk& desk) {
  std::vector<std::uint32_t> values;
  for (const canopen::Object& object : canopen::kObjects) {
    if (object.storage != canopen::Storage::kParameter || object.type == canopen::Type::kDomain) continue;
    values.push_back(desk.client->read(object.index, object.sub));
  }
  values.push_back(desk.client->read(0x2140, 2));
  return values;
}

/// A machine whose motor is connected the wrong way round, never enabled before.
void connect_wrongly(Desk& desk) {
  desk.wiring = {.motor_reversed = true, .checked = false};
  desk.flash = host::HostNonvolatile{2, 2048, 8};
  desk.power_on();
}

// The master's power fails twice. Nothing is known of the travel.
TEST(BusCommission, FromNothingToAStoredModelAcrossPowerCuts) {
  const TemporaryDirectory folder;
  Desk desk(viscous_bench(), kSeed);
  connect_wrongly(desk);
  const std::uint32_t stored = desk.client->read(0x2211, 9);
  const double velocity_mps = desk.client->read_real(0x2000, 0x0B);
  const double following_m = desk.client->read_real(0x2000, 0x0F);
  for (const char* cut_at : {"look_1", "try_1"}) {
    EXPECT_THROW(run(desk, folder, {}, cut_at), PowerCut);
    // The drive was given back what it had; what was found is in the folder.
    EXPECT_EQ(desk.client->read_real(0x2000, 0x0B), velocity_mps);
    EXPECT_FALSE(std::filesystem::exists(folder / "axis" / "deployed.toml"));
  }
  // A reversed motor alone is in the flash, which acts from a start on.
  EXPECT_EQ(desk.client->read(0x2211, 9), stored + 1);
  const CommissionResult result = run(desk, folder, {});
  const std::string text = text_of(result);
  EXPECT_NE(text.find("direction: the motor is connected the other way round"), std::string::npos) << text;
  const auto ends = CommissionFolder(folder / "axis", drive_title(*desk.client)).found("ends");
  EXPECT_TRUE(ends.at("low_switch").get<bool>() && ends.at("high_switch").get<bool>());
  // Where the axis came to rest behind the switch's edge.
  EXPECT_NEAR(ends.at("low_m").get<double>(), 0.0, 0.5e-3);
  EXPECT_NEAR(ends.at("high_m").get<double>(), desk.bench.axis.stroke_m, 0.5e-3);
  ASSERT_GE(result.trials.size(), 3U);
  EXPECT_EQ(result.trials[2].effect, "viscous");
  EXPECT_NEAR(result.mass_kg, desk.bench.axis.mass_kg, 0.1 * desk.bench.axis.mass_kg);
  const double with_mass = spread_of(result.trials.front().rms_m).mean;
  const double best = spread_of(result.trials[result.deployed].rms_m).mean;
  EXPECT_LT(best, 0.2 * with_mass);
  EXPECT_GT(best, 0.01 * with_mass);
  EXPECT_LT(result.axis_s, 180.0);
  EXPECT_GT(result.axis_s, 60.0);

  // Off, stored, and after a power-on of the drive as it was deployed, within the limits of before.
  EXPECT_EQ(desk.client->read(0x2211, 9), stored + 2);
  desk.power_on();
  const ModelParameters deployed =
      target_parameters(read_controller_model(folder / "axis" / "deployed.toml").target_terms);
  EXPECT_EQ(desk.client->read(0x2140, 2), model_hash(deployed));
  EXPECT_EQ(desk.client->read(0x2500, 2), 1U);
  EXPECT_EQ(desk.client->read_real(0x2000, 0x0B), velocity_mps);
  EXPECT_EQ(desk.client->read_real(0x2000, 0x0F), following_m);
  EXPECT_EQ(desk.client->read(0x1005, 0), 0x80U);
  desk.enable();
  EXPECT_EQ(desk.client->read(0x6041, 0) & 0x6FU, 0x27U);
}

/// What was said when it stopped.
std::string reason(Desk& desk, const TemporaryDirectory& folder, const BusAxis& told) {
  try {
    run(desk, folder, told);
  } catch (const CommissionStopped& stopped) {
    return stopped.what();
  } catch (const DriveLost& lost) {
    return std::string("lost: ") + lost.what();
  }
  return "";
}

BusAxis known_ends(const Desk& desk, double beyond_m = 0.0) {
  BusAxis told;
  told.low_m = 0.0;
  told.high_m = desk.bench.axis.stroke_m + beyond_m;
  return told;
}

// Somebody disables the drive, at different times: in the pulses, in the feedback, in the travel.
TEST(BusCommission, StopsWhereTheDriveIsDisabledAndGivesBackWhatItHad) {
  for (const std::uint64_t tick : {8'000U, 70'000U, 150'000U}) {
    const TemporaryDirectory folder;
    Desk desk(viscous_bench(), kSeed);
    const std::vector<std::uint32_t> before = held_by(desk);
    int sent = 0;
    desk.link->each_tick = [&](std::uint64_t now) {
      if (now < tick || sent == 20 || !desk.drive->controller().driving()) return;
      ++sent;
      CanFrame stop;
      stop.id = 0x205;  // RPDO 1: controlword 0, mode 0
      stop.length = 3;
      desk.port.send(stop);
    };
    const std::string why = reason(desk, folder, known_ends(desk));
    EXPECT_NE(why.find("disabled"), std::string::npos) << tick << why;
    desk.link->each_tick = nullptr;
    EXPECT_EQ(desk.client->read(0x6041, 0) & 0x6FU, 0x40U) << tick;
    EXPECT_EQ(held_by(desk), before) << tick;
    EXPECT_EQ(desk.client->read(0x2211, 9), 1U) << tick;
    EXPECT_FALSE(std::filesystem::exists(folder / "axis" / "deployed.toml"));
  }
}

TEST(BusCommission, ALimitSwitchWithinTheTravelIsSaidSo) {
  const TemporaryDirectory folder;
  Desk desk(viscous_bench(), kSeed);
  const std::vector<std::uint32_t> before = held_by(desk);
  const std::string why = reason(desk, folder, known_ends(desk, 0.05));
  EXPECT_NE(why.find("does not get through its travel of 450.0 mm"), std::string::npos) << why;
  EXPECT_NE(why.find("by a limit switch"), std::string::npos) << why;
  EXPECT_EQ(held_by(desk), before);
}

// The cable breaks in a pulse and in a motion: the drive brakes by itself, and is off or holds.
TEST(BusCommission, WithoutAMasterTheDriveStopsByItself) {
  for (const std::uint64_t tick : {12'000U, 150'000U}) {
    const TemporaryDirectory folder;
    Desk desk(viscous_bench(), kSeed);
    desk.link->each_tick = [&](std::uint64_t now) { desk.link->cut = desk.link->cut || now > tick; };
    const std::string why = reason(desk, folder, known_ends(desk));
    EXPECT_EQ(why.rfind("lost: node 5", 0), 0U) << why;
    desk.link->each_tick = nullptr;
    desk.link->cut = false;
    for (int i = 0; i < 10'000; ++i) desk.drive->step();
    const auto place = static_cast<std::int32_t>(desk.client->read(0x6063, 0));
    for (int i = 0; i < 5000; ++i) desk.drive->step();
    EXPECT_LE(std::abs(static_cast<std::int32_t>(desk.client->read(0x6063, 0)) - place), 2) << tick;
  }
}

/// Killed while the axis is held between two motions, with nobody to switch it off.
TEST(BusCommission, ARunThatWasKilledGoesOnThoughTheAxisIsStillHeld) {
  const TemporaryDirectory folder;
  Desk desk(viscous_bench(), kSeed);
  desk.link->each_tick = [&](std::uint64_t now) { desk.link->cut = desk.link->cut || now > 150'000; };
  EXPECT_NE(reason(desk, folder, known_ends(desk)), "");
  desk.link->each_tick = nullptr;
  desk.link->cut = false;
  for (int i = 0; i < 10'000; ++i) desk.drive->step();
  desk.client->write(0x6040, 0, 0x80, 2);
  desk.enable();
  ASSERT_EQ(desk.client->read(0x6041, 0) & 0x6FU, 0x27U);
  EXPECT_THROW(run(desk, folder, known_ends(desk), "look_1"), PowerCut);
  EXPECT_EQ(desk.client->read(0x6041, 0) & 0x6FU, 0x40U);
}

TEST(BusCommission, ADriveThatIsEnabledOrCountsInAnotherUnitIsLeftAlone) {
  Desk desk(viscous_bench(), kSeed);
  const auto refusal = [&] {
    const TemporaryDirectory folder;
    try {
      run(desk, folder, known_ends(desk));
    } catch (const UsageError& refused) {
      return std::string(refused.what());
    }
    return std::string();
  };
  desk.client->write(0x608F, 1, 200, 4);
  EXPECT_NE(refusal().find("has a user's unit"), std::string::npos);
  desk.client->write(0x608F, 1, 1, 4);
  desk.enable();
  EXPECT_NE(refusal().find("is enabled"), std::string::npos);
  EXPECT_EQ(desk.client->read(0x6041, 0) & 0x6FU, 0x27U);
}

}  // namespace
}  // namespace slipstack::workbench
