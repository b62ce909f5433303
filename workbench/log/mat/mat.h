// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "workbench/log/byte_source.h"
#include "workbench/log/csv/raw_table.h"

namespace slipstack::workbench {

// Bytes at the head of a MAT-file that tell its version.
inline constexpr std::size_t kMatHeaderSize = 128;

// True for the head of a MAT-file of level 5, and of 7.3 or HDF5, which read_mat() refuses by name.
bool looks_like_mat(std::string_view head);

// Reads a MATLAB level 5 MAT-file (save -v6, -v7; Octave, SciPy): real vectors become columns, real scalars
// and rows of characters header entries. They are variables, or the fields of the one struct that has a field
// time_s. A vector whose name is not that of a column is an error, as in CSV; what is neither vector, scalar
// nor text is left out with a note. `name` is how error messages show the file, `source` gives its bytes from
// the first on, `file_size` of them. Throws InputError. One variable at a time is in memory beside the
// result.
//
// After "MAT-File Format" (The MathWorks), chapter 1. A reader of our own, because the library at hand (matio
// 1.5.23) takes more than 10 s for some damaged files of 3 KB (measured: 2 of 400 random mutations of a
// compressed struct); it writes the files that test this one.
RawTable read_mat(const std::string& name, ByteSource& source, std::size_t file_size);

}  // namespace slipstack::workbench
