// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>

namespace slipstack {

/// One reading of the encoder, once per tick.
struct EncoderReading {
  std::int32_t counts = 0;    ///< absolute; may wrap modulo 2^32
  std::uint32_t latched = 0;  ///< Clock ticks at which the counts were taken
  bool valid = true;          ///< false: signal lost, cable open, position not trustworthy
};

/// Position of the axis. Read once per tick, from the tick's interrupt: at most some 20 instructions, never
/// waits. The resolution is a parameter of the axis, not of the board.
template <class E>
concept Encoder = requires(E encoder) {
  { encoder.read() } -> std::same_as<EncoderReading>;
};

}  // namespace slipstack
