// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/parameters/parameters.h"
#include "firmware/control/supervision/faults.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/friction/displacement.h"
#include "hal/include/encoder.h"
#include "hal/include/motor_current.h"

namespace slipstack {

/// What the sensors report at a tick.
struct TickInputs {
  EncoderReading encoder;
  CurrentReading current;
  bool overrun = false;       ///< this tick began late, or the last one took too long
  std::uint32_t digital = 0;  ///< levels of the input terminals
};

/// Checks the readings of the sensors before the tick uses them.
class FaultMonitor {
 public:
  /// Constants of the tick; made outside it.
  struct Bounds {
    std::int32_t largest_step = 0;
    std::int32_t largest_change = 0;  ///< of the step, from one tick to the next
    std::int32_t largest_error = 0;
    std::int32_t mismatch_ticks = 0;
    std::int32_t stall_ticks = 0;
    float over_current_A = 0.0F;
    float mismatch_A = 0.0F;
    float stall_current_A = 0.0F;
  };
  static Bounds bounds(const AxisParameters& axis) {
    const float per_tick = axis.velocity_limit_mps * axis.tick_s / axis.encoder_resolution_m;
    Bounds bound;
    // Half as much again as the axis may move, and a count at either end.
    bound.largest_step = static_cast<std::int32_t>(approx::clamp(1.5F * per_tick + 2.0F, 2.0F, 1.0e9F));
    // No force changes half of the largest velocity in a tick: a reading that stands still in motion, or
    // turns round, is the encoder's fault. What remains is left to jitter of the tick.
    bound.largest_change = static_cast<std::int32_t>(approx::clamp(0.5F * per_tick + 2.0F, 2.0F, 1.0e9F));
    bound.largest_error = static_cast<std::int32_t>(
        approx::clamp(axis.following_error_m / axis.encoder_resolution_m, 1.0F, 1.0e9F));
    bound.mismatch_ticks = static_cast<std::int32_t>(axis.current_mismatch_s / axis.tick_s);
    bound.stall_ticks = static_cast<std::int32_t>(axis.stall_s / axis.tick_s);
    bound.over_current_A = axis.over_current_A;
    bound.mismatch_A = axis.current_mismatch_A;
    bound.stall_current_A = axis.stall_current_A;
    return bound;
  }

  void reset(std::int32_t counts) {
    last_counts_ = counts;
    last_step_ = 0;
    late_ = true;  // there is no step before to compare with
    fast_ = false;
    mismatched_ = stalled_ = over_ = 0;
  }

  /// The counts and the measured current of the last check.
  std::int32_t last_counts() const { return last_counts_; }
  float last_A() const { return last_A_; }
  /// Counts of the last tick.
  std::int32_t last_step() const { return last_step_; }

  /// The first fault of this tick. `set_point_A` was commanded a tick ago; `reference_counts` is where the
  /// axis should be; `driving`: the current is on.
  Fault check(const Bounds& bound, const TickInputs& in, std::int32_t reference_counts, float set_point_A,
              bool driving) {
    const std::int32_t step = difference(in.encoder.counts, last_counts_);
    last_counts_ = in.encoder.counts;
    // A late tick sees a longer way, and the next one a shorter.
    const std::int32_t change = difference(step, last_step_);
    const bool late = in.overrun || late_;
    last_step_ = step;
    late_ = in.overrun;
    const float measured_A = in.current.current_A;
    last_A_ = measured_A;
    const bool stands = step == 0 && approx::absolute(set_point_A) > bound.stall_current_A;
    stalled_ = stands ? stalled_ + 1 : 0;
    const bool plausible = in.current.valid && approx::absolute(measured_A - set_point_A) <= bound.mismatch_A;
    mismatched_ = plausible ? 0 : mismatched_ + 1;
    if (!in.encoder.valid) return Fault::kEncoderLoss;
    if (outside(change, bound.largest_change) && !late) return Fault::kEncoderJump;
    if (approx::absolute(measured_A) > bound.over_current_A) [[unlikely]] {
      // Once at its begin; then again where it does not end while the axis is braked.
      if (++over_ == 1 || over_ > bound.mismatch_ticks) return Fault::kOverCurrent;
    } else {
      over_ = 0;
    }
    if (mismatched_ > bound.mismatch_ticks) return Fault::kCurrentSensor;
    if (!driving) return Fault::kNone;
    const bool fast = outside(step, bound.largest_step);
    if (fast != fast_) [[unlikely]] {
      fast_ = fast;
      if (fast && !in.overrun) return Fault::kOverspeed;
    }
    const std::int32_t error = difference(reference_counts, in.encoder.counts);
    if (outside(error, bound.largest_error)) return Fault::kFollowingError;
    if (stalled_ > bound.stall_ticks) return Fault::kStall;
    if (in.overrun) return Fault::kTickOverrun;
    return Fault::kNone;
  }

 private:
  // One comparison for both sides: 0 < limit <= 10^9.
  static bool outside(std::int32_t value, std::int32_t limit) {
    return static_cast<std::uint32_t>(value) + static_cast<std::uint32_t>(limit) >
           2 * static_cast<std::uint32_t>(limit);
  }

  std::int32_t last_counts_ = 0;
  std::int32_t last_step_ = 0;
  bool late_ = false;
  std::int32_t over_ = 0;  // ticks of over-current
  bool fast_ = false;      // overspeed
  std::int32_t mismatched_ = 0;
  std::int32_t stalled_ = 0;
  float last_A_ = 0.0F;
};

}  // namespace slipstack
