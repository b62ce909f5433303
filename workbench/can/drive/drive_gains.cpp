// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/drive/drive_gains.h"

#include <fmt/format.h>

#include "firmware/canopen/telemetry/trace.h"
#include "workbench/can/drive/drive_access.h"

namespace slipstack::workbench {
namespace {

using namespace slipstack::canopen;

void set_gains(SdoClient& drive, const DriveController& gains) {
  drive.write_real(kAxisIndex, 5, gains.position_gain_per_s);
  drive.write_real(kAxisIndex, 6, gains.velocity_gain_N_s_per_m);
  drive.write_real(kAxisIndex, 7, gains.integral_per_s);
  for (std::size_t i = 0; i < gains.notch.size(); ++i) {
    const auto sub = static_cast<std::uint8_t>(kNotchFirst + 3 * i);
    drive.write_real(kAxisIndex, sub, gains.notch[i].frequency_Hz);
    drive.write_real(kAxisIndex, static_cast<std::uint8_t>(sub + 1), gains.notch[i].damping);
    drive.write_real(kAxisIndex, static_cast<std::uint8_t>(sub + 2), gains.notch[i].depth);
  }
}

void await_enabled(SdoClient& drive, bool wanted) {
  for (int i = 0; is_enabled(drive) != wanted; ++i) {
    if (i > 5000) drive.fail(wanted ? "does not become enabled again" : "does not leave operation enabled");
  }
}

}  // namespace

DriveController read_controller(SdoClient& drive) {
  DriveController made;
  made.tick_s = drive.read_real(kAxisIndex, 2);
  made.mass_kg = model_mass_kg(drive);
  made.observer_rad_per_s = drive.read_real(kAxisIndex, 4);
  made.position_gain_per_s = drive.read_real(kAxisIndex, 5);
  made.velocity_gain_N_s_per_m = drive.read_real(kAxisIndex, 6);
  made.integral_per_s = drive.read_real(kAxisIndex, 7);
  made.disturbance_share = drive.read_real(kAxisIndex, 8);
  for (std::size_t i = 0; i < made.notch.size(); ++i) {
    const auto sub = static_cast<std::uint8_t>(kNotchFirst + 3 * i);
    made.notch[i] = {drive.read_real(kAxisIndex, sub),
                     drive.read_real(kAxisIndex, static_cast<std::uint8_t>(sub + 1)),
                     drive.read_real(kAxisIndex, static_cast<std::uint8_t>(sub + 2))};
  }
  if (!(made.tick_s > 0.0) || !(made.mass_kg > 0.0))
    drive.fail("has no mass or no tick (2100h, 2000h:02); is it commissioned?");
  return made;
}

void apply_gains(SdoClient& drive, const DriveController& gains, bool store, const Show& show) {
  show("apply", -1.0);
  const std::uint32_t hash = drive.read(kModelIndex, 1);
  if (hash != drive.read(kModelIndex, 2))
    drive.fail("another model is staged than runs; deploy it, or restore the one that runs, first");
  const DriveController before = read_controller(drive);
  const bool was_enabled = is_enabled(drive);
  if (was_enabled) {
    drive.write(0x6040, 0, 0x07, 2);
    await_enabled(drive, false);
  }
  set_gains(drive, gains);
  if (const auto refused = apply_staged(drive, hash)) {
    set_gains(drive, before);
    drive.fail(fmt::format("does not take the gains (result {}, 2140h:04); the old ones run on", *refused));
  }
  if (store) store_parameters(drive);
  if (!was_enabled) return;
  drive.write(0x6040, 0, 0x0F, 2);
  await_enabled(drive, true);
}

}  // namespace slipstack::workbench
