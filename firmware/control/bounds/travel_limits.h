// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/bounds/motion_bounds.h"
#include "firmware/control/bounds/position_range.h"
#include "firmware/control/current/current_limit.h"
#include "firmware/control/reference/reference.h"
#include "firmware/control/streams/cyclic_position.h"
#include "firmware/control/supervision/digital_io.h"

namespace slipstack {

/// The ends of the travel: those of the user's range, and the places where a limit switch became active.
/// What each mode does before them stands with the mode: stream_path.h (cyclic position and velocity),
/// torque_bounds.h (torque), point_to_point.h (moves and profile velocity).
class TravelLimits {
 public:
  /// In the tick: the switches and the bounds as they are now. Towards a limit switch that is active the
  /// reference brakes.
  void step(const IoMasks& io, const MotionBounds& bounds, const DigitalInputs& inputs, std::int32_t counts,
            ReferenceGenerator& reference, CyclicPosition& stream, std::uint16_t& limits) {
    const std::uint32_t active = bounds.switches ? inputs.limits(io) : 0U;
    if (active != active_ || bounds.number != bounds_number_) [[unlikely]]
      change(io, bounds, active, counts);
    if (active == 0) return;
    limits |= kLimitSwitch;
    const bool outwards = (active & (reference.forward() ? io.positive_limit : io.negative_limit)) != 0;
    if (!outwards) return;
    if (reference.playing()) reference.stop();
    if (reference.tracking()) stream.end();
  }

  /// In the tick: the range that is left.
  const PositionRange& range() const { return range_; }
  /// Outside the tick: the same, of these bounds, which the next tick may be the first to see.
  PositionRange range(const MotionBounds& bounds) const { return bounds.range.and_within(at_switches_); }

 private:
  void change(const IoMasks& io, const MotionBounds& bounds, std::uint32_t active, std::int32_t counts) {
    const std::uint32_t changed = active ^ active_;
    if ((changed & io.positive_limit) != 0)
      at_switches_.highest = (active & io.positive_limit) != 0 ? counts : PositionRange::kNoHighest;
    if ((changed & io.negative_limit) != 0)
      at_switches_.lowest = (active & io.negative_limit) != 0 ? counts : PositionRange::kNoLowest;
    active_ = active;
    bounds_number_ = bounds.number;
    range_ = range(bounds);
  }

  PositionRange range_;
  PositionRange at_switches_;        // the part of it that limit switches have left
  std::uint32_t bounds_number_ = 0;  // of the bounds whose range is in it
  std::uint32_t active_ = 0;         // limit switches, by terminal
};

}  // namespace slipstack
