// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace slipstack::sim {

inline constexpr double kTurn = 2.0 * std::numbers::pi;  ///< one turn in rad

}  // namespace slipstack::sim
