// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "workbench/log/byte_source.h"
#include "workbench/log/csv/raw_table.h"

namespace slipstack::workbench {

// Bytes at the start of a MAT-file that contain its version.
inline constexpr std::size_t kMatHeaderSize = 128;

// Relative precision of numbers that were stored as single.
inline constexpr double kSinglePrecision = 0x1p-24;

// True for the start of a MAT-file of level 5 or version 7.3, and of any HDF5 file, which read_mat() refuses.
bool looks_like_mat(std::string_view head);

// True for the start of a MAT-file of version 7.3, which read_mat73() reads.
bool is_mat73(std::string_view head);

// Reads a MATLAB level 5 MAT-file (save -v6, -v7; Octave, SciPy): real vectors become columns, real scalars
// and rows of characters header entries. They are variables, or the fields of the one struct that has a field
// time_s. A vector whose name is not that of a column is an error, as in CSV; other content than vectors,
// scalars and text is left out with a note. `name` stands for the file in error messages, `source` supplies
// its `file_size` bytes. Throws InputError. Memory: one variable at a time in addition to the result.
//
// Source: "MAT-File Format" (The MathWorks), chapter 1. The library matio (1.5.23) is not used for reading,
// because it takes more than 10 s for some damaged files of 3 KB (measured: 2 of 400 random mutations of a
// compressed struct); the tests write their files with it.
RawTable read_mat(const std::string& name, ByteSource& source, std::size_t file_size);

}  // namespace slipstack::workbench
