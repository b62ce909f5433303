// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/can/commands/master.h"
#include "workbench/frequency/drive_controller.h"

namespace slipstack::workbench {

/// The feedback that the drive's objects describe (2000h, 2100h).
DriveController read_controller(SdoClient& drive);

/// Disables the drive, writes gains and notches, applies them between two ticks, and enables it again if it
/// was; stores them if asked. Throws UsageError when the drive refuses, with the gains of before staged
/// again.
void apply_gains(SdoClient& drive, const DriveController& gains, bool store, const Show& show);

}  // namespace slipstack::workbench
