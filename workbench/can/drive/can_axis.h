// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "workbench/can/client/sdo_client.h"
#include "workbench/loop/live_axis.h"

namespace slipstack::workbench {

/// What is told of the axis behind a drive on the bus, beside what the drive holds itself.
struct BusAxis {
  std::optional<double> low_m = {};  ///< ends of the travel, in the drive's positions; both or none
  std::optional<double> high_m = {};
  std::optional<double> largest_velocity_mps = {};  ///< else the drive's limit (2000h:0B)
  std::optional<double> magnet_pitch_m = {};
  int period_ms = 1;  ///< of set-points and samples
};

/// Where it is kept what the drive held before, beyond the life of this program.
struct DriveMemory {
  std::string kept;                              ///< by an earlier run; empty: there was none
  std::function<void(const std::string&)> keep;  ///< whole, before it returns
  bool positions_matter = false;  ///< of the earlier run: what it found is at places of the axis
};

/// What tells the drive from others: product and serial number. Throws UsageError.
std::string drive_title(SdoClient& drive);

/// The axis of a drive on the bus: resolution, motor constant, largest current and limits are those that the
/// drive holds (2000h). Where neither `told` nor the software limits (607Dh) say where the travel ends, it is
/// not known, and to be searched.
///
/// What the drive held before is kept in `memory` before anything is changed, and give_back() puts it back,
/// also in a later run. Everything is changed in the drive's memory alone until
/// keep() stores it, but for a reversed motor, which acts from a start on: this is stored and the drive
/// started anew.
///
/// Where the master falls silent in motion, the drive stops by itself (2403h, 6007h). Throws UsageError where
/// the drive is enabled, at fault, not described, has a user's unit, or has lost the positions of an earlier
/// run.
std::unique_ptr<LiveAxis> can_axis(SdoClient& drive, const BusAxis& told, DriveMemory memory);

}  // namespace slipstack::workbench
