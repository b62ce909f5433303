// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "workbench/log/raw_table.h"

namespace slipstack::workbench {

// Bytes at the head of a MAT-file that tell its version.
inline constexpr std::size_t kMatHeaderSize = 128;

// True for the head of a MAT-file of level 5, and of 7.3 or HDF5, which read_mat() refuses by name.
bool looks_like_mat(std::string_view head);

// Reads a MATLAB level 5 MAT-file: real vectors become columns, real scalars and character rows become header
// entries. They are variables, or the fields of the one struct that has a field time_s. A vector whose name
// is not that of a column is an error, as in CSV; what is neither vector, scalar nor text is left out with a
// note. `name` is how error messages show the file. `head` holds its first kMatHeaderSize bytes, or all of
// them when there are fewer.
RawTable read_mat(const std::string& name, const std::filesystem::path& path, std::string_view head,
                  std::size_t file_size);

}  // namespace slipstack::workbench
