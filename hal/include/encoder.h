// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>

namespace slipstack {

/// One reading of the encoder, once per tick.
struct EncoderReading {
  std::int32_t counts = 0;    ///< may wrap modulo 2^32
  std::uint32_t latched = 0;  ///< Clock ticks at which the counts were taken
  bool valid = true;          ///< false: signal lost, cable open, position not trustworthy
};

/// An encoder with index marks offers this too: true once for each mark that passed since the last call, with
/// the counts at which it passed. Called once per tick, before read().
template <class E>
concept IndexedEncoder = requires(E encoder, std::int32_t& counts) {
  { encoder.take_index(counts) } -> std::same_as<bool>;
};

/// Position of the axis. Read once per tick, from the tick's interrupt: at most some 20 instructions, never
/// waits. The resolution is a parameter of the axis, not of the board.
template <class E>
concept Encoder = requires(E encoder) {
  { encoder.read() } -> std::same_as<EncoderReading>;
};

}  // namespace slipstack
