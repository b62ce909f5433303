// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace slipstack::workbench {

/// The content of a regular file of at most `most` bytes. Throws InputError.
std::string read_whole(const std::filesystem::path& path, std::size_t most);

/// A file name without folders, control characters and leading dots; `otherwise` where nothing is left of it.
std::string plain_name(const std::string& name, const std::string& otherwise);

/// Whether `path`, links followed, lies in `folder`.
bool lies_in(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace slipstack::workbench
