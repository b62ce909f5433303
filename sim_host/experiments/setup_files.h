// SPDX-License-Identifier: Apache-2.0
// The set-ups of sim_host/setups, as they are compiled into the program.
#pragma once

#include <string_view>
#include <vector>

namespace slipstack::sim {

struct SetupFile {
  std::string_view name;
  std::string_view text;  // TOML
};

/// All of them, by name; generated at build time.
const std::vector<SetupFile>& setup_files();

}  // namespace slipstack::sim
