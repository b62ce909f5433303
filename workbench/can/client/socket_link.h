// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "workbench/can/client/can_link.h"

namespace slipstack::workbench {

/// An interface of this machine, and what its errors call it. Throws UsageError, one line, when there is none
/// of that name.
std::unique_ptr<CanLink> open_link(const std::string& interface, const std::string& called = "--can");

/// The names of this machine's CAN interfaces, in order.
std::vector<std::string> can_interfaces();

}  // namespace slipstack::workbench
