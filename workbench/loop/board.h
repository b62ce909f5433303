// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "sim_host/loop/lockstep_board.h"

namespace slipstack::workbench {

/// The controller in lock-step on a board: host (in this process), mps2-an386 or mps2-an500 (in the
/// emulator). `image`: empty for the one that the build makes. Throws UsageError for another name, for an
/// image with host, and where the emulator or the image is missing.
std::unique_ptr<sim::LockstepBoard> lockstep_board(const std::string& board, const std::string& image);

/// Throws UsageError as lockstep_board() does for its options; starts nothing.
void check_board(const std::string& board, const std::string& image);

}  // namespace slipstack::workbench
