// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "firmware/control/bounds/position_range.h"
#include "firmware/control/parameters/parameters.h"
#include "firmware/control/reference/braking.h"
#include "firmware/control/reference/motion_limits.h"
#include "firmware/control/streams/sync_clock.h"
#include "firmware/control/streams/tracking.h"
#include "firmware/control/supervision/state_machine.h"

namespace slipstack {

/// What the user bounds motion by, beside the parameters of the axis; may change at any time. Where the axis
/// allows less, that counts.
struct UserBounds {
  static constexpr float kNone = 3.0e38F;
  PositionRange range;
  bool switches = true;                         ///< limit switches bound it too; homing uses them itself
  float velocity_mps = kNone;                   ///< in every mode
  float profile_velocity_counts_per_s = kNone;  ///< of moves to a target
  float acceleration_counts_per_s2 = kNone;     ///< the same, and of set-points of velocity
  float deceleration_counts_per_s2 = kNone;
  float quick_stop_counts_per_s2 = kNone;
  float slow_down_counts_per_s2 = kNone;
  float slow_down_counts_per_s3 = kNone;
  float brake_release_s = 0.0F;  ///< from current on until the brake is open
  float brake_apply_s = 0.0F;    ///< from standstill until it is closed
  std::uint32_t number = 0;      ///< counted by Controller::bound()
};

/// Bounds of motion as they are used, in counts and ticks.
struct MotionBounds {
  MotionLimits motion;  ///< of moves to a target
  BrakingLimits quick_stop;
  BrakingLimits slow_down;
  TrackingLimits tracking;
  StoppingDistanceBound stopping;  ///< of the quick stop
  PositionRange range;
  bool switches = true;
  float velocity_mps = 0.0F;  ///< in torque mode
  StopTimes times;
  std::uint32_t number = 0;  ///< of the user's bounds

  /// What the path of a stream of positions is bounded by: the profile's bounds are none of it. Outside the
  /// tick.
  MotionLimits of_stream(const AxisParameters& axis) const {
    const float per_mps = axis.tick_s / axis.encoder_resolution_m;
    const float acceleration = axis.acceleration_limit_mps2 * (per_mps * axis.tick_s);
    return {velocity_mps * per_mps, acceleration, acceleration, motion.jerk};
  }

  /// Outside the tick.
  static MotionBounds of(const AxisParameters& axis, const UserBounds& user) {
    const float tick_s = axis.tick_s;
    const float per_mps = tick_s / axis.encoder_resolution_m;
    const float per_mps2 = per_mps * tick_s;
    const float per_mps3 = per_mps2 * tick_s;
    const float resolution_m = axis.encoder_resolution_m;
    MotionBounds bounds;
    bounds.velocity_mps = std::min(axis.velocity_limit_mps, user.velocity_mps);
    bounds.motion = motion_limits(axis);
    bounds.motion.velocity =
        std::min(bounds.velocity_mps * per_mps, user.profile_velocity_counts_per_s * tick_s);
    const float per_s2 = tick_s * tick_s;
    bounds.motion.acceleration =
        std::min(bounds.motion.acceleration, user.acceleration_counts_per_s2 * per_s2);
    bounds.motion.deceleration =
        std::min(bounds.motion.deceleration, user.deceleration_counts_per_s2 * per_s2);
    const float quick_mps2 = std::min(axis.quick_stop_mps2, user.quick_stop_counts_per_s2 * resolution_m);
    const float slow_mps2 = std::min(axis.quick_stop_mps2, user.slow_down_counts_per_s2 * resolution_m);
    const float slow_mps3 = std::min(axis.jerk_limit_mps3, user.slow_down_counts_per_s3 * resolution_m);
    bounds.quick_stop = braking_limits(quick_mps2 * per_mps2, bounds.motion.jerk);
    bounds.slow_down = braking_limits(slow_mps2 * per_mps2, slow_mps3 * per_mps3);
    bounds.stopping = StoppingDistanceBound::of(quick_mps2 * per_mps2, bounds.motion.jerk);
    const MotionLimits path = bounds.of_stream(axis);
    bounds.tracking = TrackingLimits::of_path(path.velocity, path.acceleration, SyncClock::kLockRange);
    bounds.range = user.range;
    bounds.switches = user.switches;
    bounds.number = user.number;
    bounds.times = {timeout_ticks(axis, quick_mps2, axis.jerk_limit_mps3),
                    timeout_ticks(axis, slow_mps2, slow_mps3),
                    static_cast<std::int32_t>(user.brake_release_s / tick_s),
                    static_cast<std::int32_t>(user.brake_apply_s / tick_s)};
    return bounds;
  }

 private:
  // Beyond the ramp itself where that is long: what the user asked for is no fault. From 1.5 times the
  // largest velocity, above which the encoder's reading counts as a jump; v / d + 2 d / j is longer than any
  // ramp.
  static std::int32_t timeout_ticks(const AxisParameters& axis, float deceleration, float jerk) {
    const float ramp_s = 1.5F * axis.velocity_limit_mps / deceleration + 2.0F * deceleration / jerk;
    const bool set = deceleration < axis.quick_stop_mps2 || jerk < axis.jerk_limit_mps3;
    const float longest_s = set ? std::max(axis.stop_timeout_s, ramp_s) : axis.stop_timeout_s;
    return static_cast<std::int32_t>(std::min(longest_s / axis.tick_s, 2.0e9F));
  }
};

}  // namespace slipstack
