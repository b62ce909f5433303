// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack {

/// The encoder that the axis has, where a board can read more than one kind.
struct EncoderInterface {
  enum class Kind : std::uint8_t { kIncremental, kBissC };

  Kind kind = Kind::kIncremental;
  std::uint8_t position_bits = 32;  ///< of a frame, 8 to 56
  std::uint8_t dropped_bits = 0;    ///< of these the lowest, which are finer than a count; at most bits - 8
};

/// What came of the frames of an absolute encoder since the start; each counter stops at its largest value.
struct FrameCounters {
  std::uint32_t silent = 0;    ///< no answer, or none in time
  std::uint32_t bad_crc = 0;   ///< the check sum is wrong
  std::uint32_t errors = 0;    ///< the encoder says itself that its position is wrong
  std::uint32_t warnings = 0;  ///< the position is right, the encoder wants service
  bool warning = false;        ///< of the last good frame
};

/// The encoder interface of a board that can read an absolute one. Used outside the tick.
class AbsoluteEncoder {
 public:
  /// While the controller has no parameters: readings may step.
  virtual void use(const EncoderInterface& interface) = 0;
  virtual FrameCounters counters() const = 0;

 protected:
  ~AbsoluteEncoder() = default;
};

/// Whether these numbers are those of an encoder that a frame can carry.
constexpr bool valid(const EncoderInterface& interface) {
  return interface.position_bits >= 8 && interface.position_bits <= 56 &&
         interface.dropped_bits + 8 <= interface.position_bits;
}

}  // namespace slipstack
