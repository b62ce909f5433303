// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

// The duration of the fastest trajectory by brute force, apart from the planner: small steps of time along
// the boundary of what velocity and acceleration allow, and the instant where braking begins by bisection. By
// Pontryagin's principle a time-optimal motion of three integrators speeds up as fast as it may, then brakes
// as fast as it may. Knows no phases and no closed form; errs by some steps.
namespace slipstack::fastest {

struct Bounds {
  double velocity, speeding, slowing, jerk;
};

struct Point {
  double x, v, a;
};

// The largest acceleration towards a higher velocity from which, step by step, zero acceleration is still
// reached there, and the bound beyond zero velocity in time.
inline double largest_rise(double v, double target, const Bounds& bound, double dt) {
  const double per_step = bound.jerk * dt;
  const double to_target =
      0.5 * per_step * (std::sqrt(1.0 + 8.0 * std::max(target - v, 0.0) / (per_step * dt)) - 1.0);
  double allowed = v < 0.0 ? bound.slowing : bound.speeding;
  // Ahead of the place where the bound falls.
  if (v < 0.0 && target > 0.0) {
    allowed = std::min(allowed, std::sqrt(bound.speeding * bound.speeding - 2.0 * bound.jerk * v));
  }
  return std::min(to_target, allowed);
}

// One step towards a velocity.
inline Point step(const Point& p, double target, const Bounds& bound, double dt) {
  double wanted = 0.0;
  if (p.v < target) wanted = largest_rise(p.v, target, bound, dt);
  if (p.v > target) wanted = -largest_rise(-p.v, -target, bound, dt);
  const double a = std::clamp(wanted, p.a - bound.jerk * dt, p.a + bound.jerk * dt);
  const double v = p.v + dt * a;
  return {p.x + 0.5 * dt * (p.v + v), v, a};
}

struct Rest {
  double x;
  std::size_t steps;
};

inline Rest brake(Point p, const Bounds& bound, double dt, std::size_t longest) {
  const double still = 2.0 * bound.jerk * dt;
  std::size_t steps = 0;
  while (steps < longest && (std::abs(p.a) > still || std::abs(p.v) > still * dt)) {
    p = step(p, 0.0, bound, dt);
    ++steps;
  }
  return {p.x, steps};
}

/// In the unit of time of the bounds, to some `dt`; `longest` where it takes longer.
inline double duration(const Point& from, double target, const Bounds& bound, double dt, double longest) {
  const auto most = static_cast<std::size_t>(longest / dt);
  const double sign = brake(from, bound, dt, most).x < target ? 1.0 : -1.0;
  std::vector<Point> speeding = {from};
  while (speeding.size() < most) {
    speeding.push_back(step(speeding.back(), sign * bound.velocity, bound, dt));
  }
  const auto reaches = [&](std::size_t i) {
    return sign * (brake(speeding[i], bound, dt, most).x - target) >= 0.0;
  };
  std::size_t low = 0;
  std::size_t high = most - 1;
  if (!reaches(high)) return longest;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (reaches(middle) ? high : low) = middle;
  }
  return dt * static_cast<double>(high + brake(speeding[high], bound, dt, most).steps);
}

}  // namespace slipstack::fastest
