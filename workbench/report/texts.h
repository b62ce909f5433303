// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

// Numbers and sentences for people, the same in the terminal and in the report.
namespace slipstack::workbench {

/// A force with its unit: "0.34 N", "12 mN".
std::string newtons(double value_N);

/// A share of one, in per cent: 0.0123 gives "1.23 %".
std::string share(double value);

/// A number of things, in the singular for one: "1 element", "4 elements".
std::string counted(std::size_t count, std::string_view thing);

/// The words with a capital first letter and a full stop.
std::string sentence(std::string words);

}  // namespace slipstack::workbench
