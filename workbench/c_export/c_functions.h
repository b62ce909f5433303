// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace slipstack::workbench {

/// A function of the C header: C99 that is C++ too, `@` for the prefix of names, `REAL` for the scalar.
struct CFunction {
  std::vector<std::string> names;  ///< that it defines, as a text mentions them
  std::string text;
};

/// Every function that a recording may call, each after those that it calls: the C forms of
/// firmware/effects/numerics/approx.h, the tables and interval.h, operation by operation. tests/unit/c_export
/// compares the forces bit by bit. `is_float`: with the bits of a float, else of a double.
std::vector<CFunction> c_functions(bool is_float);

}  // namespace slipstack::workbench
