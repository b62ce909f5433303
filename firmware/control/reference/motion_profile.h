// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "firmware/effects/numerics/approx.h"

// Motion of a third-order integrator with constant jerk, phase by phase, in continuous time. In double: 2 m
// in counts of 1 nm are 2^31, and a float has 24 bits. Counts and ticks throughout.
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

}  // namespace slipstack::trajectory
