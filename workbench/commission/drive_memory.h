// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "workbench/can/drive/can_axis.h"
#include "workbench/commission/commission_folder.h"

namespace slipstack::workbench {

/// What a drive on the bus held before its commissioning, in the folder of it (drive_before.json). Throws
/// UsageError where it cannot be read. The folder has to outlive it.
DriveMemory memory_in(CommissionFolder& folder);

}  // namespace slipstack::workbench
