// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>

namespace slipstack {

/// Digital inputs and outputs, 16 terminals each at most: bit 0 is terminal 1. Levels as they are at the
/// terminals; which of them does what, and with which polarity, are parameters of the axis. Called from the
/// tick: never waits. From reset until the first write() the outputs are low.
template <class D>
concept DigitalIo = requires(D io, std::uint32_t levels) {
  { io.read() } -> std::same_as<std::uint32_t>;  ///< all inputs at once; 0 where there is no terminal
  {io.write(levels)};                            ///< all outputs, held until the next
};

}  // namespace slipstack
