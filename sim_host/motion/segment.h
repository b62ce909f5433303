// SPDX-License-Identifier: Apache-2.0
// Segments of a test programme as closed-form functions of time.
#pragma once

#include <memory>
#include <vector>

namespace slipstack::sim {

struct MotionPoint {
  double x_m = 0.0;
  double v_mps = 0.0;
  double a_mps2 = 0.0;
};

/// One segment of motion, from standstill to standstill, on 0 … duration.
class Segment {
 public:
  virtual ~Segment() = default;
  virtual double duration_s() const = 0;
  virtual MotionPoint at(double t_s) const = 0;
};

/// Standstill.
std::unique_ptr<Segment> make_dwell(double x_m, double duration_s);

struct MoveLimits {
  double velocity_mps;
  double acceleration_mps2;
  double jerk_mps3;
};

/// Standstill to standstill in the shortest time within limits of velocity, acceleration and jerk (up to
/// seven phases of constant jerk). Throws std::invalid_argument unless all limits are positive.
std::unique_ptr<Segment> make_jerk_limited_move(double from_m, double to_m, const MoveLimits& limits);

/// Standstill to standstill by the quintic 10u³ − 15u⁴ + 6u⁵, peak velocity as given (> 0).
std::unique_ptr<Segment> make_quintic_move(double from_m, double to_m, double peak_velocity_mps);

/// A sine about `centre_m` for `cycles` whole cycles (≥ 2), faded in over the first and out over the last
/// (quintic fade: position, velocity and acceleration are continuous with the standstill before and after).
std::unique_ptr<Segment> make_sine(double centre_m, double amplitude_m, double frequency_Hz, int cycles);

}  // namespace slipstack::sim
