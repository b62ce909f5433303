// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace slipstack::workbench {

// Unusable input. what() is one line without a newline: where (file, line), what is wrong, what to do, as in
// "run.csv:17: column force_N: 'abc' is not a number; write a decimal number or remove the row".
// Commands print it as it is and exit with status 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace slipstack::workbench
