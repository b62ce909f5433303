// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "hal/plant_link/plant_link.h"

namespace slipstack::sim {

/// Set-points of a stream that the controller holds: the first are sent one in each tick, the others one in
/// each period.
inline constexpr int kSetPointsAhead = 3;

/// Puts the next set-point of a stream into the link: whole counts, and a part of one, 0 to 1; a period in
/// ticks.
inline void send_set_point(PlantLink& link, std::int64_t counts, double part, std::uint32_t period) {
  // The largest fraction that a float below 2^32 can carry.
  constexpr double kLargest = 0x1p32 - 256.0;
  link.stream_counts = static_cast<std::int32_t>(counts);
  link.stream_fraction = static_cast<std::uint32_t>(std::min(part * 0x1p32, kLargest));
  link.stream_period = period;
  link.stream_sequence = link.stream_sequence + 1;
}

}  // namespace slipstack::sim
