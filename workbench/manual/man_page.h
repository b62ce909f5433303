// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "workbench/manual/command_text.h"

namespace slipstack::workbench {

/// The man page of one command, section 1, in the macros of man(7). `version` as "slipstack 0.1.0".
std::string man_page(const CommandText& command, const std::string& version);

/// Of a command and all below it: the name of the file, as "slipstack-experiment-plan.1", and its page.
std::vector<std::pair<std::string, std::string>> man_pages(const CommandText& command,
                                                           const std::string& version);

}  // namespace slipstack::workbench
