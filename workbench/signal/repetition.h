// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace slipstack::workbench {

/// The period with which a signal repeats, in samples, to a fraction of one; zero where it does not repeat at
/// least three times. The signal a period later is the same where their correlation is 0.98 at least.
/// O(n log n).
double repetition_period(std::span<const double> signal);

}  // namespace slipstack::workbench
