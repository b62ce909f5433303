// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace slipstack::workbench {

/// A MATLAB level 5 MAT-file, not compressed, with one column vector of doubles for each name (MAT-File
/// Format, The MathWorks, chapter 1). Names are those of MATLAB variables, at most 63 characters. Cost: 8
/// bytes for each value.
std::string mat_file(const std::vector<std::pair<std::string, std::vector<double>>>& variables);

}  // namespace slipstack::workbench
