// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/segments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "workbench/base/quantity.h"

namespace slipstack::workbench {
namespace {

constexpr double kRest_s = 0.1;
constexpr double kLongestHold_s = 2.0;
/// Fraction of the stroke that segments leave free at each end. Chosen.
constexpr double kEnd = 0.05;
constexpr double kOfVelocity = 0.8;  ///< fastest segment, relative to the velocity limit; chosen

class SegmentCatalogue {
 public:
  SegmentCatalogue(const AxisLimits& limits, double presliding_m)
      : limits_(limits), presliding_m_(presliding_m) {
    low_m_ = limits.low_m + kEnd * limits.stroke_m();
    length_m_ = (1.0 - 2.0 * kEnd) * limits.stroke_m();
  }

  std::vector<MotionSegment> take() {
    const double fastest = kOfVelocity * limits_.velocity_mps;
    constexpr double kStep = 2.5;
    for (int k = 0; k < 9; ++k) {
      const double speed = fastest * std::pow(kStep, -k);
      add_stroke(speed);
      for (const double frequency_Hz : {0.7, 2.5, 9.0}) add_wobble(speed, frequency_Hz);
    }
    for (const double share : {0.5, 0.15}) add_pass(share * fastest);
    for (const double share : {1.0, 0.3, 0.05}) add_moves(share * length_m_);
    for (const double place : {0.1, 0.5, 0.9}) {
      for (const double travels : {0.1, 0.6, 3.0})
        add_sine(low_m_ + place * length_m_, travels * presliding_m_);
    }
    return std::move(segments_);
  }

 private:
  /// A segment in both directions. Its distance must exceed the pre-sliding travel by far, since it would
  /// otherwise contain information about the hysteresis only.
  template <class Body>
  void add_both_ways(std::string name, double speed_mps, double distance_m, Body body) {
    if (distance_m > length_m_ || distance_m < 4.0 * presliding_m_) return;
    const double ramp_s = ramp_time_s(speed_mps, limits_);
    const double start_m = low_m_ + 0.5 * (length_m_ - distance_m);
    segments_.push_back({std::move(name), start_m, [=](MotionBuilder& motion) {
                           for (const double way : {1.0, -1.0}) {
                             motion.ramp(0.0, way * speed_mps, ramp_s);
                             body(motion, way * speed_mps);
                             motion.ramp(way * speed_mps, 0.0, ramp_s);
                             motion.dwell(kRest_s);
                           }
                         }});
  }

  void add_stroke(double speed_mps) {
    const double ramp_m = speed_mps * ramp_time_s(speed_mps, limits_);
    const double hold_s = std::min(kLongestHold_s, (length_m_ - ramp_m) / speed_mps);
    if (hold_s <= 0.0) return;
    add_both_ways(fmt::format("move there and back at {}", quantity(speed_mps, "m/s")), speed_mps,
                  ramp_m + speed_mps * hold_s,
                  [hold_s](MotionBuilder& motion, double velocity) { motion.hold(velocity, hold_s); });
  }

  void add_wobble(double speed_mps, double frequency_Hz) {
    constexpr double kDepth = 0.95;
    const double rate = 2.0 * std::numbers::pi * frequency_Hz;
    const double swing = 0.5 * kDepth * speed_mps;
    if (swing * rate > 0.8 * limits_.acceleration_mps2 || swing * rate * rate > 0.8 * limits_.jerk_mps3)
      return;
    const double ramp_m = speed_mps * ramp_time_s(speed_mps, limits_);
    const double cycle_m = speed_mps * (1.0 - 0.5 * kDepth) / frequency_Hz;
    const int wanted = static_cast<int>(std::ceil(kLongestHold_s * frequency_Hz));
    const int cycles = std::min(wanted, static_cast<int>((length_m_ - ramp_m) / cycle_m));
    if (cycles < 1) return;
    add_both_ways(fmt::format("one-way motion of {} that slows down and speeds up {} times a second",
                              quantity(speed_mps, "m/s"), frequency_Hz),
                  speed_mps, ramp_m + cycles * cycle_m * 1.001, [=](MotionBuilder& motion, double velocity) {
                    motion.wobble(velocity, kDepth, frequency_Hz, cycles);
                  });
  }

  void add_pass(double speed_mps) {
    const double ramp_m = speed_mps * ramp_time_s(speed_mps, limits_);
    constexpr double kLongest_s = 12.0;
    const double faster = std::max(speed_mps, length_m_ / kLongest_s);
    if (ramp_m >= length_m_ || faster > kOfVelocity * limits_.velocity_mps) return;
    const double hold_s = (length_m_ * 0.999 - faster * ramp_time_s(faster, limits_)) / faster;
    if (hold_s <= 0.0) return;
    add_both_ways(fmt::format("pass over the whole travel, there and back, at {}", quantity(faster, "m/s")),
                  faster, length_m_ * 0.9995,
                  [hold_s](MotionBuilder& motion, double velocity) { motion.hold(velocity, hold_s); });
  }

  void add_moves(double distance_m) {
    const double start_m = low_m_ + 0.5 * (length_m_ - distance_m);
    segments_.push_back({fmt::format("fast moves of {} with standstills", quantity(distance_m, "m")), start_m,
                         [this_limits = limits_, start_m, distance_m](MotionBuilder& motion) {
                           for (int i = 0; i < 3; ++i) {
                             motion.move_to(start_m + distance_m, this_limits);
                             motion.dwell(0.3);
                             motion.move_to(start_m, this_limits);
                             motion.dwell(0.3);
                           }
                         }});
  }

  void add_sine(double place_m, double amplitude_m) {
    constexpr double kFrequency_Hz = 1.0;
    const double rate = 2.0 * std::numbers::pi * kFrequency_Hz;
    // The rising and falling amplitude increases the peaks by a factor of at most 3.
    if (3.0 * amplitude_m * rate * rate * rate > limits_.jerk_mps3 ||
        3.0 * amplitude_m * rate * rate > limits_.acceleration_mps2 || amplitude_m > 0.05 * length_m_) {
      return;
    }
    segments_.push_back(
        {fmt::format("sines of {} amplitude at {}", quantity(amplitude_m, "m"), quantity(place_m, "m")),
         place_m, [=](MotionBuilder& motion) { motion.sine(amplitude_m, kFrequency_Hz, 4); }});
  }

  AxisLimits limits_;
  double presliding_m_;
  double low_m_ = 0.0;
  double length_m_ = 0.0;
  std::vector<MotionSegment> segments_;
};

}  // namespace

std::vector<MotionSegment> possible_segments(const AxisLimits& limits, double presliding_m) {
  return SegmentCatalogue(limits, presliding_m).take();
}

}  // namespace slipstack::workbench
