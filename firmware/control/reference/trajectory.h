// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "firmware/control/reference/motion_profile.h"
#include "firmware/control/reference/velocity_change.h"
#include "firmware/effects/numerics/approx.h"

// Time-optimal trajectories of a third-order integrator with bounded velocity, acceleration and jerk, in
// continuous time. Planned outside the tick, in double. Counts and ticks throughout.
namespace slipstack::trajectory {

/// Shortest trajectories to a position at rest. Holds what planning needs; not for the stack.
class Planner {
 public:
  /// The shortest way from velocity and acceleration to rest, wherever that is.
  const Profile& stop(const State& from, const Limits& limits) {
    profile_.begin(from);
    change_velocity(profile_, 0.0, limits);
    return profile_;
  }

  /// The shortest change to this velocity, wherever that leads.
  const Profile& change(const State& from, double velocity, const Limits& limits) {
    profile_.begin(from);
    change_velocity(profile_, velocity, limits);
    return profile_;
  }

  /// As move(), but without turning round: where the stopping distance leads beyond `target`, seen in this
  /// direction (1 or -1), a stop.
  const Profile& approach(const State& from, double target, double direction, const Limits& limits) {
    if ((target - stop(from, limits).end().position) * direction <= 0.0) return profile_;
    return move(from, target, limits);
  }

  /// The fastest motion that ends at rest at `target`, from any state: speed up towards it, until what is
  /// left is the way to rest. The place where braking leads to is monotone in the time of speeding up, so one
  /// root is found, to 2^-20 of a count. Bounded: kMostSteps evaluations of the stopping distance, 25 at most
  /// in 10^6 random states.
  const Profile& move(const State& from, double target, const Limits& limits) {
    steps_ = 0;
    const double way = target - resting_place(from, limits);
    profile_.begin(from);
    if (way != 0.0) speed_up(target, way, limits);
    change_velocity(profile_, 0.0, limits);
    return profile_;
  }

  /// Evaluations of the stopping distance in the last move.
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
