// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/motions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipstack::workbench {
namespace {

constexpr double kRate_Hz = 1000.0;
constexpr double kMargin = 0.05;  // of the travel, at either end
constexpr double kForceShare = 0.5;
constexpr double kLeastForceShare = 0.1;  // where friction takes the rest
constexpr double kJerkTime_s = 0.03;
constexpr double kTestPace = 0.75;
constexpr double kReach_s = 1.5;

/// What of the room is reached in some seconds, about its middle.
AxisLimits within_reach(AxisLimits limits) {
  const double less_m = 0.5 * std::max(0.0, limits.stroke_m() - kReach_s * limits.velocity_mps);
  limits.low_m += less_m;
  limits.high_m -= less_m;
  return limits;
}

double place(const AxisLimits& limits, double share) {
  return limits.low_m + share * limits.stroke_m();
}

/// To and fro at one speed, over two thirds of the room, and for a second at most.
void stroke(MotionBuilder& builder, const AxisLimits& limits, double speed_mps) {
  const double ramp_s = std::max(0.05, ramp_time_s(speed_mps, limits));
  const double room_m = 0.65 * limits.stroke_m();
  const double hold_s = std::clamp(room_m / speed_mps - ramp_s, 0.0, 0.8);
  if (speed_mps * ramp_s > room_m) return;
  for (const double v : {speed_mps, -speed_mps}) {
    builder.ramp(0.0, v, ramp_s);
    builder.hold(v, hold_s);
    builder.ramp(v, 0.0, ramp_s);
  }
}

}  // namespace

AxisLimits first_limits(const Nameplate& nameplate, double mass_kg, double friction_N) {
  AxisLimits limits;
  limits.low_m = nameplate.low_m + kMargin * nameplate.travel_m;
  limits.high_m = nameplate.low_m + (1.0 - kMargin) * nameplate.travel_m;
  const double most_N = nameplate.force_limit_N();
  const double spare_N = std::max(kLeastForceShare * most_N, kForceShare * most_N - friction_N);
  limits.acceleration_mps2 = std::min(nameplate.largest_acceleration_mps2, spare_N / mass_kg);
  limits.jerk_mps3 = limits.acceleration_mps2 / kJerkTime_s;
  // What is reached on half of the room.
  limits.velocity_mps = std::min(0.8 * nameplate.largest_velocity_mps,
                                 std::sqrt(0.5 * limits.acceleration_mps2 * limits.stroke_m()));
  limits.force_N = kForceShare * most_N;
  return limits;
}

double approach_mps(const AxisLimits& limits) {
  return std::min({0.1, limits.stroke_m() / 4.0, limits.velocity_mps});
}

SetPoints holding_motion(const AxisLimits& limits) {
  MotionBuilder builder(kRate_Hz, place(limits, 0.5));
  builder.dwell(kHoldTo_s);
  builder.sine(50e-6, 3.0, 3);
  builder.dwell(0.3);
  return builder.points();
}

SetPoints travel_motion(const AxisLimits& limits) {
  AxisLimits slow = limits;
  slow.velocity_mps = std::min(limits.velocity_mps, 2.0 * approach_mps(limits));
  slow.acceleration_mps2 = std::min(limits.acceleration_mps2, 1.0);
  slow.jerk_mps3 = std::min(limits.jerk_mps3, 20.0);
  MotionBuilder builder(kRate_Hz, place(limits, 0.5));
  builder.dwell(0.3);
  for (const double share : {0.0, 1.0, 0.5}) {
    builder.move_to(place(limits, share), slow);
    builder.dwell(0.2);
  }
  return builder.points();
}

SetPoints first_look(const AxisLimits& room, double pace, double encoder_resolution_m) {
  const AxisLimits limits = within_reach(room);
  MotionBuilder builder(kRate_Hz, place(limits, 0.5));
  builder.dwell(0.3);
  const double least_m = 5.0 * encoder_resolution_m;
  for (const double share : {0.25, 0.75}) {
    builder.move_to(place(limits, share), limits, pace);
    builder.dwell(0.1);
    for (const double amplitude_m : {3e-6, 10e-6, 30e-6, 100e-6})
      builder.sine(std::max(least_m, amplitude_m), 5.0, 3);
  }
  builder.move_to(place(limits, 0.15), limits, pace);
  AxisLimits slow = limits;
  slow.velocity_mps *= pace;
  slow.acceleration_mps2 *= pace * pace;
  slow.jerk_mps3 *= pace * pace * pace;
  for (const double speed_mps : {2e-3, 8e-3, 30e-3, 0.1, 0.3}) {
    if (speed_mps <= slow.velocity_mps) stroke(builder, slow, speed_mps);
  }
  for (const double share : {0.98, 0.02, 0.6, 0.3}) {
    builder.move_to(place(limits, share), limits, pace);
    builder.dwell(0.15);
  }
  builder.dwell(0.2);
  return builder.points();
}

TrackingTest tracking_test(const AxisLimits& room) {
  const AxisLimits limits = within_reach(room);
  const double centre_m = place(limits, 0.4);
  const double wide_m = std::min(2e-3, 0.1 * limits.stroke_m());
  const double wide_Hz =
      std::min(3.0, std::sqrt(0.4 * limits.acceleration_mps2 / wide_m) / (2.0 * std::numbers::pi));
  MotionBuilder builder(kRate_Hz, centre_m);
  TrackingTest test;
  for (std::size_t i = 0; i < TrackingTest::kCycles; ++i) {
    builder.sine(20e-6, 5.0, 3);
    builder.sine(wide_m, wide_Hz, 3);
    for (const double share : {0.73, 0.4}) {
      builder.move_to(place(limits, share), limits, kTestPace);
      builder.dwell(0.15);
    }
    if (i == 0) test.cycle_points = builder.size();
  }
  test.motion = builder.points();
  return test;
}

}  // namespace slipstack::workbench
