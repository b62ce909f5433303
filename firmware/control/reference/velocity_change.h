// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/control/reference/motion_profile.h"

// Shortest changes of velocity within bounds of acceleration and jerk.
namespace slipstack::trajectory {

namespace detail {

// A change of velocity seen along itself: the velocity that is left at zero acceleration is to rise.
class Rise {
 public:
  Rise(Profile& profile, double target, const Limits& limits)
      : profile_(profile),
        limits_(limits),
        sign_(free_velocity(profile.end(), limits.jerk) < target ? 1.0 : -1.0),
        target_(sign_ * target) {}

  // Adds the phases of the shortest change. O(1): at most six.
  void run() {
    const double speeding = limits_.acceleration;
    const double slowing = limits_.deceleration;
    if (target_ <= 0.0) return rise(slowing);
    ramp(0.0);  // only if acceleration points the other way
    if (velocity() >= 0.0) return rise(speeding);
    if (speeding >= slowing) {
      cross_from_lower_bound(speeding, slowing);
    } else {
      cross_from_higher_bound(speeding, slowing);
    }
  }

 private:
  static double free_velocity(const State& s, double jerk) {
    const double magnitude = s.acceleration < 0.0 ? -s.acceleration : s.acceleration;
    return s.velocity + 0.5 * s.acceleration * magnitude / jerk;
  }

  double velocity() const { return sign_ * profile_.end().velocity; }
  double acceleration() const { return sign_ * profile_.end().acceleration; }
  // Velocity that ramps between two accelerations gain.
  double gain(double from, double to) const { return 0.5 * (to * to - from * from) / limits_.jerk; }

  // Up to an acceleration at full jerk; nothing if it is higher already.
  void ramp(double to) { profile_.add(sign_ * limits_.jerk, (to - acceleration()) / limits_.jerk); }
  void fall(double to) { profile_.add(-sign_ * limits_.jerk, (acceleration() - to) / limits_.jerk); }
  void ramp_or_fall(double to) {
    ramp(to);
    fall(to);
  }
  void hold_until(double velocity_then) { profile_.add(0.0, (velocity_then - velocity()) / acceleration()); }

  // To the target with one bound of the acceleration: ramp, hold, ramp.
  void rise(double bound) {
    const double a = acceleration();
    const double peak = square_root(limits_.jerk * (target_ - velocity()) + 0.5 * a * a);
    if (peak <= bound) {
      ramp(peak);
    } else {
      ramp_or_fall(bound);
      hold_until(target_ - gain(0.0, bound));
    }
    fall(0.0);
  }

  // From below zero velocity to above, the bound rising at zero.
  void cross_from_lower_bound(double speeding, double slowing) {
    const double a = acceleration();
    if (a > slowing && velocity() + gain(slowing, a) >= 0.0) return rise(speeding);
    if (a <= slowing && velocity() + gain(a, slowing) >= 0.0) return rise(speeding);
    if (target_ <= gain(0.0, slowing)) return rise(slowing);
    ramp_or_fall(slowing);
    hold_until(0.0);
    rise(speeding);
  }

  // The same, the bound falling at zero: the acceleration is there in time, if it can.
  void cross_from_higher_bound(double speeding, double slowing) {
    const double a = acceleration();
    if (target_ <= gain(0.0, speeding)) return rise(slowing);
    const double needed = -velocity();
    if (a <= speeding && needed <= gain(a, speeding)) return rise(speeding);
    if (a > speeding && needed <= gain(speeding, a)) return rise(speeding);
    const double peak = square_root(0.5 * (a * a + speeding * speeding) + limits_.jerk * needed);
    if (peak <= slowing) {
      ramp(peak);
    } else {
      ramp_or_fall(slowing);
      hold_until(-gain(speeding, slowing));
    }
    fall(speeding);
    rise(speeding);
  }

  Profile& profile_;
  const Limits& limits_;
  double sign_;
  double target_;
};

}  // namespace detail

/// Adds the shortest change to this velocity and zero acceleration, from whatever state the profile ends in.
/// A state beyond the limits is brought back within them at full jerk.
inline void change_velocity(Profile& profile, double velocity, const Limits& limits) {
  detail::Rise(profile, velocity, limits).run();
  profile.settle(velocity);
}

}  // namespace slipstack::trajectory
