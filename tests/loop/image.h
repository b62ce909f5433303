// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace slipstack::loop {

/// The firmware for an emulated board, from the target's build.
inline std::string image_of(const std::string& machine) {
  return SLIPSTACK_TARGET_BUILD "/bin/slipstack-" + machine + ".elf";
}

}  // namespace slipstack::loop
