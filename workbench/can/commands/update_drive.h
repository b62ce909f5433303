// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/can/commands/master.h"
#include "workbench/can/commands/update_file.h"

namespace slipstack::workbench {

/// Puts a program into the drive's spare slot, starts it, and waits until it has reported in; the text to
/// print. A transfer that breaks off goes on where it was. Throws UsageError, one line with the reason: the
/// program that runs has not changed then, or has come back.
std::string update_drive(SdoClient& drive, const UpdateFile& file, const Show& show);

}  // namespace slipstack::workbench
