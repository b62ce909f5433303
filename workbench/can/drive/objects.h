// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/can/client/sdo_client.h"

namespace slipstack::workbench {

/// Reads or writes one object of the drive by SDO, with the type, the name and the unit of its dictionary;
/// one line for the terminal. `request`: "6041", "2500:03", "2500:03=1.2", "6040=0Fh", "1010:01=save", or
/// "reset" (NMT reset node, until the node is there again). Throws UsageError: malformed, no such object, or
/// the drive refuses.
std::string access_object(SdoClient& drive, const std::string& request);

}  // namespace slipstack::workbench
