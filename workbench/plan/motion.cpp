// SPDX-License-Identifier: Apache-2.0
#include "workbench/plan/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipstack::workbench {
namespace {

/// Motions use this fraction of the limits, since a controller has following errors. Chosen.
constexpr double kMargin = 0.8;

/// Peaks of the derivatives of the quintic over the unit interval: velocity, acceleration, jerk.
constexpr double kQuinticVelocity = 1.875;
constexpr double kQuinticAcceleration = 5.7735026918962573;
constexpr double kQuinticJerk = 60.0;

struct Quintic {
  double value, first, second, third;
};

/// 10u^3 - 15u^4 + 6u^5 and its derivatives, u in [0, 1].
Quintic quintic(double u) {
  return {u * u * u * (10.0 + u * (-15.0 + 6.0 * u)), 30.0 * u * u * (1.0 - u) * (1.0 - u),
          60.0 * u * (1.0 - u) * (1.0 - 2.0 * u), 60.0 - 360.0 * u + 360.0 * u * u};
}

}  // namespace

MotionBuilder::MotionBuilder(double rate_Hz, double start_m) : position_m_(start_m) {
  points_.rate_Hz = rate_Hz;
}

void MotionBuilder::append(double duration_s, const std::function<State(double)>& at) {
  const double step_s = 1.0 / points_.rate_Hz;
  const auto count = static_cast<std::size_t>(std::max(1.0, std::round(duration_s * points_.rate_Hz)));
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) * step_s;
    const State now = at(t);
    points_.position_m.push_back(position_m_);
    points_.velocity_mps.push_back(now.velocity_mps);
    points_.acceleration_mps2.push_back(now.acceleration_mps2);
    // Simpson's rule is exact for cubics, which velocities nearly are within a sample.
    position_m_ += step_s / 6.0 *
                   (now.velocity_mps + 4.0 * at(t + 0.5 * step_s).velocity_mps + at(t + step_s).velocity_mps);
  }
}

void MotionBuilder::dwell(double duration_s) {
  append(duration_s, [](double) { return State{0.0, 0.0}; });
}

void MotionBuilder::hold(double velocity_mps, double duration_s) {
  append(duration_s, [=](double) { return State{velocity_mps, 0.0}; });
}

void MotionBuilder::ramp(double from_mps, double to_mps, double duration_s) {
  const double whole_s = std::max(1.0, std::ceil(duration_s * points_.rate_Hz)) / points_.rate_Hz;
  append(whole_s, [=](double t) {
    const Quintic q = quintic(std::min(t / whole_s, 1.0));
    return State{from_mps + (to_mps - from_mps) * q.value, (to_mps - from_mps) * q.first / whole_s};
  });
}

void MotionBuilder::wobble(double velocity_mps, double depth, double frequency_Hz, int cycles) {
  const double period_s = std::ceil(points_.rate_Hz / frequency_Hz) / points_.rate_Hz;
  const double rate = 2.0 * std::numbers::pi / period_s;
  append(cycles * period_s, [=](double t) {
    return State{velocity_mps * (1.0 - 0.5 * depth * (1.0 - std::cos(rate * t))),
                 -velocity_mps * 0.5 * depth * rate * std::sin(rate * t)};
  });
}

void MotionBuilder::sine(double amplitude_m, double frequency_Hz, int cycles) {
  const double period_s = std::ceil(points_.rate_Hz / frequency_Hz) / points_.rate_Hz;
  const double rate = 2.0 * std::numbers::pi / period_s;
  const double end_s = cycles * period_s;
  append(end_s, [=](double t) {
    const bool in = t < period_s;
    const bool out = t > end_s - period_s;
    const double u = in ? t / period_s : out ? std::max(0.0, (end_s - t) / period_s) : 1.0;
    const Quintic q = in || out ? quintic(u) : Quintic{1.0, 0.0, 0.0, 0.0};
    const double sign = out ? -1.0 : 1.0;
    const double slope = sign * q.first / period_s;
    const double bend = q.second / (period_s * period_s);
    const double s = std::sin(rate * t);
    const double c = std::cos(rate * t);
    return State{amplitude_m * (slope * s + q.value * rate * c),
                 amplitude_m * (bend * s + 2.0 * slope * rate * c - q.value * rate * rate * s)};
  });
}

void MotionBuilder::move_to(double position_m, const AxisLimits& limits, double pace) {
  const double distance_m = position_m - position_m_;
  const double length_m = std::abs(distance_m);
  if (length_m < 1e-9) return;
  const double fastest_s =
      std::max({kQuinticVelocity * length_m / (kMargin * limits.velocity_mps),
                std::sqrt(kQuinticAcceleration * length_m / (kMargin * limits.acceleration_mps2)),
                std::cbrt(kQuinticJerk * length_m / (kMargin * limits.jerk_mps3))});
  const double whole_s = std::ceil(fastest_s / pace * points_.rate_Hz) / points_.rate_Hz;
  append(whole_s, [=](double t) {
    const Quintic q = quintic(std::min(t / whole_s, 1.0));
    return State{distance_m * q.first / whole_s, distance_m * q.second / (whole_s * whole_s)};
  });
  position_m_ = position_m;  // removes the error of Simpson's rule, some 1e-15
}

double ramp_time_s(double step_mps, const AxisLimits& limits) {
  const double step = std::abs(step_mps);
  return std::max(kQuinticVelocity * step / (kMargin * limits.acceleration_mps2),
                  std::sqrt(kQuinticAcceleration * step / (kMargin * limits.jerk_mps3)));
}

AxisLimits extremes_of(const SetPoints& points) {
  const auto largest = [](const std::vector<double>& values) {
    double most = 0.0;
    for (const double value : values) most = std::max(most, std::abs(value));
    return most;
  };
  AxisLimits found;
  const auto [low, high] = std::minmax_element(points.position_m.begin(), points.position_m.end());
  found.low_m = *low;
  found.high_m = *high;
  found.velocity_mps = largest(points.velocity_mps);
  found.acceleration_mps2 = largest(points.acceleration_mps2);
  for (std::size_t i = 1; i < points.size(); ++i) {
    found.jerk_mps3 = std::max(found.jerk_mps3, points.rate_Hz * std::abs(points.acceleration_mps2[i] -
                                                                          points.acceleration_mps2[i - 1]));
  }
  return found;
}

}  // namespace slipstack::workbench
