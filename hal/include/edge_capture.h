// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace slipstack {

/// An edge of an input terminal, and what the encoder counted at it.
struct CapturedEdge {
  std::int32_t counts = 0;  ///< as EncoderReading has them
  bool high = false;        ///< the level after the edge
};

/// An input terminal whose edges the encoder's counter itself catches, where a board has one: the counts are
/// those of the edge, not those of the next tick. Used outside the tick, which it costs nothing.
class EdgeCapture {
 public:
  /// Edges that a board keeps between two calls of take(), at least.
  static constexpr std::size_t kKept = 15;

  /// The terminal, 1 to 16, which DigitalIo reads as well; 0 while no edge is caught, as with an encoder that
  /// the counter does not count.
  virtual std::uint8_t terminal() const = 0;
  /// The edges since the last call, oldest first, and how many; of more than fit, or were kept, the latest.
  virtual std::size_t take(std::span<CapturedEdge> edges) = 0;

 protected:
  ~EdgeCapture() = default;
};

}  // namespace slipstack
