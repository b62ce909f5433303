// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "workbench/log/csv/raw_table.h"

namespace slipstack::workbench {

// Reads a MAT-file of version 7.3 (MATLAB's save -v7.3), an HDF5 file, as read_mat() reads those of level 5.
// Throws InputError; one that names the package where libhdf5 is not there.
//
// The file is read by libhdf5 in a process of its own, which is given `file_size` / 10 MB/s + 20 s of a
// processor: that library faults, or does not end, on some damaged files, and then this file is damaged, and
// nothing else happens. Memory: the numbers twice while they are handed over.
RawTable read_mat73(const std::string& name, const std::filesystem::path& path, std::size_t file_size);

}  // namespace slipstack::workbench
