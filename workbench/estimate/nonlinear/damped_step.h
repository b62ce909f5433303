// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace slipstack::workbench {

/// Takes as much of a step as lowers the cost: all of it, or a half, a quarter... down to 2^-`most_halvings`.
/// `lowers(share)` tries a share, and keeps it where it returns true. False: none of them lowers the cost.
template <class Lowers>
bool take_damped_step(int most_halvings, Lowers&& lowers) {
  double share = 1.0;
  for (int halving = 0; halving <= most_halvings; ++halving, share *= 0.5) {
    if (lowers(share)) return true;
  }
  return false;
}

}  // namespace slipstack::workbench
