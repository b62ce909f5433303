// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace slipstack::workbench {

/// Unusable input. what() is one line without a newline: where (file, line), what is wrong, what to do, as in
/// "run.csv:17: column force_N: 'abc' is not a number; write a decimal number or remove the row".
/// Commands print it as it is and exit with status 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Wrong use of a command, or a place that cannot be written: printed as one line, exit status 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A run that had begun and could not be finished: printed as one line, exit status 1.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace slipstack::workbench
