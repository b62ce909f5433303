// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "hal/include/can_port.h"

// Position and current that a drive sends with each SYNC, in TPDO 3 as it is delivered (docs/can.md).
namespace slipstack::workbench {

inline constexpr std::uint32_t kProducesSync = 0x40000000;  ///< of 1005h
// Identifiers less the node's id, as CiA 301 gives them (table 40).
inline constexpr std::uint32_t kEmergencyId = 0x80;
inline constexpr std::uint32_t kErrorControlId = 0x700;  ///< boot-up and heartbeat
/// 1A02h: tick, position, current.
inline constexpr std::uint32_t kMotionMapping[] = {0x22100510, 0x60630020, 0x22000B10};

/// A value of a frame's data, from this byte on.
template <class Value>
Value value_at(const CanFrame& frame, std::size_t place) {
  Value value{};
  std::memcpy(&value, &frame.data[place], sizeof value);
  return value;
}

/// A data frame with this identifier and length.
inline bool is_frame(const CanFrame& frame, std::uint32_t id, std::uint8_t length) {
  return frame.id == id && !frame.extended && !frame.remote && frame.length == length;
}

/// The values of one tick.
struct MotionSample {
  std::int64_t tick = 0;
  std::int32_t counts = 0;
  double current_A = 0.0;  ///< about the instant of the counts
};

/// Reads the next frame of kMotionMapping into `sample`, which holds the one before: of the tick it has 16
/// bits only. `limit_A`: 2000h:09, the full scale of the current.
inline void read_motion(const CanFrame& frame, double limit_A, MotionSample& sample) {
  sample.tick +=
      static_cast<std::uint16_t>(value_at<std::uint16_t>(frame, 0) - static_cast<std::uint16_t>(sample.tick));
  sample.counts = value_at<std::int32_t>(frame, 2);
  sample.current_A = static_cast<double>(value_at<std::int16_t>(frame, 6)) / 32767.0 * limit_A;
}

}  // namespace slipstack::workbench
