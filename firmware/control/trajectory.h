// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "firmware/effects/approx.h"

// Time-optimal trajectories of a third-order integrator with bounded velocity, acceleration and jerk, in
// continuous time. Planned outside the tick, in double: 2 m in counts of 1 nm are 2^31, and a float has 24
// bits. Counts and ticks throughout.
namespace slipstack::trajectory {

/// All positive. Acceleration bounds the rise of the speed, deceleration its fall.
struct Limits {
  double velocity = 0.0;
  double acceleration = 0.0;
  double deceleration = 0.0;
  double jerk = 0.0;
};

struct State {
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
};

inline State after(const State& from, double jerk, double ticks) {
  return {from.position +
              ticks * (from.velocity + ticks * (0.5 * from.acceleration + ticks * jerk * (1.0 / 6.0))),
          from.velocity + ticks * (from.acceleration + 0.5 * ticks * jerk), from.acceleration + ticks * jerk};
}

/// Square root by two steps of Newton's iteration from that of a float; 0 where a float has none.
inline double square_root(double a) {
  const float seed = approx::fast_square_root(a > 0.0 ? static_cast<float>(a) : 0.0F);
  if (!(seed > 0.0F)) return 0.0;
  auto root = static_cast<double>(seed);
  for (int step = 0; step < 2; ++step) root = 0.5 * (root + a / root);
  return root;
}

struct Phase {
  State begin;
  double jerk = 0.0;
  double ticks = 0.0;
};

/// Phases of constant jerk, one after the other.
class Profile {
 public:
  static constexpr std::size_t kMost = 14;

  void begin(const State& from) {
    end_ = from;
    size_ = 0;
  }
  /// Neighbours of equal jerk are joined; nothing is added for a time that is not positive.
  void add(double jerk, double ticks) {
    if (!(ticks > 0.0)) return;
    if (size_ > 0 && phases_[size_ - 1].jerk == jerk) {
      phases_[size_ - 1].ticks += ticks;
    } else if (size_ < kMost) {
      phases_[size_] = {end_, jerk, ticks};
      ++size_;
    }
    end_ = after(end_, jerk, ticks);
  }
  /// Keeps the phases before this one, and of this one only its first ticks.
  void cut(std::size_t phase, double ticks) {
    const Phase last = phases_[phase];
    size_ = phase;
    end_ = last.begin;
    add(last.jerk, ticks);
  }
  /// What rounding left of the acceleration, and of the velocity that was meant, is taken out.
  void settle(double velocity) {
    end_.velocity = velocity;
    end_.acceleration = 0.0;
  }

  const State& end() const { return end_; }
  std::size_t size() const { return size_; }
  const Phase& operator[](std::size_t i) const { return phases_[i]; }

 private:
  State end_;
  std::size_t size_ = 0;
  std::array<Phase, kMost> phases_{};
};

/// The farthest places of a profile, its begin included.
struct Extent {
  double lowest = 0.0;
  double highest = 0.0;
};

inline Extent extent(const Profile& profile) {
  Extent found;
  if (profile.size() == 0) return found;
  found = {profile[0].begin.position, profile[0].begin.position};
  const auto include = [&found](double position) {
    if (position < found.lowest) found.lowest = position;
    if (position > found.highest) found.highest = position;
  };
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const Phase& phase = profile[i];
    include(after(phase.begin, phase.jerk, phase.ticks).position);
    // Where the velocity passes zero: v + a t + j t^2 / 2, by the form that has no small difference.
    const double v = phase.begin.velocity;
    const double a = phase.begin.acceleration;
    const double root = square_root(a * a - 2.0 * phase.jerk * v);
    const double sum = a + (a < 0.0 ? -root : root);
    for (const double ticks :
         {sum != 0.0 ? -2.0 * v / sum : -1.0, phase.jerk != 0.0 ? -sum / phase.jerk : -1.0}) {
      if (ticks > 0.0 && ticks < phase.ticks) include(after(phase.begin, phase.jerk, ticks).position);
    }
  }
  return found;
}

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

/// Shortest trajectories to a position at rest. Holds what planning needs; not for the stack.
class Planner {
 public:
  /// The shortest way from velocity and acceleration to rest, wherever that is.
  const Profile& stop(const State& from, const Limits& limits) {
    profile_.begin(from);
    change_velocity(profile_, 0.0, limits);
    return profile_;
  }

  /// The shortest way to rest at `target`, from any state: speed up towards it, until what is left is the way
  /// to rest. The place where braking leads to is monotone in the time of speeding up, so one root is found,
  /// to 2^-20 of a count. Bounded: kMostSteps evaluations of the way to rest, 25 at most in 10^6 random
  /// states.
  const Profile& move(const State& from, double target, const Limits& limits) {
    steps_ = 0;
    const double way = target - resting_place(from, limits);
    profile_.begin(from);
    if (way != 0.0) speed_up(target, way, limits);
    change_velocity(profile_, 0.0, limits);
    return profile_;
  }

  /// Evaluations of the way to rest in the last move.
  int steps() const { return steps_; }
  static constexpr int kMostSteps = 80;

 private:
  static constexpr double kTolerance = 0x1p-20;          // counts
  static constexpr double kRelativeTolerance = 0x1p-48;  // of the places between which it is searched
  static constexpr int kMostInterpolated = 30;

  double resting_place(const State& from, const Limits& limits) {
    ++steps_;
    trial_.begin(from);
    change_velocity(trial_, 0.0, limits);
    return trial_.end().position;
  }

  // Towards the highest velocity, until braking leads to the target.
  void speed_up(double target, double way, const Limits& limits) {
    const double sign = way > 0.0 ? 1.0 : -1.0;
    double short_by = -sign * way;  // of the target, if braking begins where the phase begins
    change_velocity(profile_, sign * limits.velocity, limits);
    for (std::size_t i = 0; i < profile_.size(); ++i) {
      const State& then = i + 1 < profile_.size() ? profile_[i + 1].begin : profile_.end();
      const double beyond = sign * (resting_place(then, limits) - target);
      if (beyond >= 0.0) return profile_.cut(i, root(profile_[i], target, sign, beyond, limits));
      short_by = beyond;
    }
    profile_.add(0.0, -short_by / limits.velocity);
  }

  // The time in a phase from which braking leads to the target: inverse quadratic interpolation where it
  // holds, else bisection (Chandrupatla, Advances in Engineering Software 28 (1997)).
  double root(const Phase& phase, double target, double sign, double at_end, const Limits& limits) {
    const auto excess = [&](double ticks) {
      return sign * (resting_place(after(phase.begin, phase.jerk, ticks), limits) - target);
    };
    Sample near{phase.ticks, at_end};
    Sample far{0.0, excess(0.0)};
    const double tolerance = kTolerance + kRelativeTolerance * (near.excess - far.excess);
    double share = 0.5;
    while (steps_ < kMostSteps) {
      const double ticks = near.ticks + share * (far.ticks - near.ticks);
      if (ticks == near.ticks || ticks == far.ticks) break;
      const Sample now{ticks, excess(ticks)};
      const Sample last = (now.excess > 0.0) == (near.excess > 0.0) ? near : far;
      if ((now.excess > 0.0) != (near.excess > 0.0)) far = near;
      near = now;
      if (near.excess < tolerance && near.excess > -tolerance) break;
      share = steps_ < kMostInterpolated ? next_share(near, far, last) : 0.5;
    }
    return near.ticks;
  }

  struct Sample {
    double ticks, excess;
  };

  // Where between two samples on either side of the root the next one lies; `last` is the one before.
  static double next_share(const Sample& near, const Sample& far, const Sample& last) {
    const double xi = (near.ticks - far.ticks) / (last.ticks - far.ticks);
    const double phi = (near.excess - far.excess) / (last.excess - far.excess);
    if (!(phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi)) return 0.5;
    const double share = near.excess / (far.excess - near.excess) * last.excess / (far.excess - last.excess) +
                         (last.ticks - near.ticks) / (far.ticks - near.ticks) * near.excess /
                             (last.excess - near.excess) * far.excess / (last.excess - far.excess);
    return approx::clamp(share, 1e-6, 1.0 - 1e-6);
  }

  Profile profile_;
  Profile trial_;
  int steps_ = 0;
};

}  // namespace slipstack::trajectory
