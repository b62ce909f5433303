// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace slipstack::workbench {

/// Writes a file as a whole: beside its place, forced to the disk, then renamed over it, and the folder
/// forced to the disk too. Whoever reads it, also after a crash or a power cut, sees the old file or the new
/// one. Throws UsageError, one line, when the disk is full or the folder cannot be written; what was there
/// stays.
void write_atomically(const std::filesystem::path& path, const std::string& content);

}  // namespace slipstack::workbench
