// SPDX-License-Identifier: Apache-2.0
#include "sim_host/motion/segment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace slipstack::sim {
namespace {

class Dwell final : public Segment {
 public:
  Dwell(double x_m, double duration_s) : x_m_(x_m), duration_s_(duration_s) {}
  double duration_s() const override { return duration_s_; }
  MotionPoint at(double) const override { return {x_m_, 0.0, 0.0}; }

 private:
  double x_m_;
  double duration_s_;
};

// The first half of the move: jerk up, constant acceleration, jerk down, cruise; the second half is its
// mirror.
class JerkLimitedMove final : public Segment {
 public:
  JerkLimitedMove(double from_m, double to_m, const MoveLimits& limits)
      : from_m_(from_m), distance_m_(std::fabs(to_m - from_m)), sign_(to_m < from_m ? -1.0 : 1.0) {
    jerk_ = limits.jerk_mps3;
    double velocity = limits.velocity_mps;
    set_ramp(velocity, limits.acceleration_mps2);
    if (velocity * ramp_s() > distance_m_) {
      // No cruise: the peak velocity at which two ramps just cover the distance, by bisection.
      double low = 0.0;
      for (int i = 0; i < 100; ++i) {
        const double middle = 0.5 * (low + velocity);
        set_ramp(middle, limits.acceleration_mps2);
        (middle * ramp_s() > distance_m_ ? velocity : low) = middle;
      }
      velocity = low;
      set_ramp(velocity, limits.acceleration_mps2);
    }
    cruise_s_ = velocity > 0.0 ? std::max(0.0, distance_m_ / velocity - ramp_s()) : 0.0;
  }

  double duration_s() const override { return 2.0 * ramp_s() + cruise_s_; }

  MotionPoint at(double t_s) const override {
    const bool second_half = t_s > 0.5 * duration_s();
    MotionPoint point = first_half(second_half ? duration_s() - t_s : t_s);
    if (second_half) {
      point.x_m = distance_m_ - point.x_m;
      point.a_mps2 = -point.a_mps2;
    }
    return {from_m_ + sign_ * point.x_m, sign_ * point.v_mps, sign_ * point.a_mps2};
  }

 private:
  double ramp_s() const { return 2.0 * jerk_s_ + hold_s_; }

  void set_ramp(double velocity, double acceleration) {
    if (velocity * jerk_ >= acceleration * acceleration) {
      jerk_s_ = acceleration / jerk_;
      hold_s_ = velocity / acceleration - jerk_s_;
    } else {
      jerk_s_ = std::sqrt(velocity / jerk_);
      hold_s_ = 0.0;
    }
  }

  MotionPoint first_half(double t_s) const {
    MotionPoint point;
    const std::array<double, 4> lengths = {jerk_s_, hold_s_, jerk_s_, 1e300};
    const std::array<double, 4> jerks = {jerk_, 0.0, -jerk_, 0.0};
    for (std::size_t phase = 0; phase < lengths.size(); ++phase) {
      const double h = std::min(std::max(t_s, 0.0), lengths[phase]);
      const double j = jerks[phase];
      if (phase == 3) point.a_mps2 = 0.0;
      point.x_m += h * (point.v_mps + h * (point.a_mps2 / 2.0 + h * j / 6.0));
      point.v_mps += h * (point.a_mps2 + h * j / 2.0);
      point.a_mps2 += h * j;
      t_s -= lengths[phase];
      if (t_s <= 0.0) break;
    }
    return point;
  }

  double from_m_;
  double distance_m_;
  double sign_;
  double jerk_ = 1.0;
  double jerk_s_ = 0.0;
  double hold_s_ = 0.0;
  double cruise_s_ = 0.0;
};

// 10u³ − 15u⁴ + 6u⁵ and its derivatives.
MotionPoint quintic(double u) {
  const double r = 1.0 - u;
  return {u * u * u * (10.0 + u * (-15.0 + 6.0 * u)), 30.0 * u * u * r * r, 60.0 * u * r * (1.0 - 2.0 * u)};
}

class QuinticMove final : public Segment {
 public:
  QuinticMove(double from_m, double to_m, double peak_velocity_mps)
      : from_m_(from_m), way_m_(to_m - from_m), duration_s_(1.875 * std::fabs(way_m_) / peak_velocity_mps) {}
  double duration_s() const override { return duration_s_; }
  MotionPoint at(double t_s) const override {
    if (duration_s_ == 0.0) return {from_m_, 0.0, 0.0};
    const MotionPoint q = quintic(std::clamp(t_s / duration_s_, 0.0, 1.0));
    return {from_m_ + way_m_ * q.x_m, way_m_ * q.v_mps / duration_s_,
            way_m_ * q.a_mps2 / (duration_s_ * duration_s_)};
  }

 private:
  double from_m_;
  double way_m_;
  double duration_s_;
};

class Sine final : public Segment {
 public:
  Sine(double centre_m, double amplitude_m, double frequency_Hz, int cycles)
      : centre_m_(centre_m), amplitude_m_(amplitude_m), period_s_(1.0 / frequency_Hz), cycles_(cycles) {}
  double duration_s() const override { return cycles_ * period_s_; }
  MotionPoint at(double t_s) const override {
    const double w = 2.0 * std::numbers::pi / period_s_;
    const double s = std::sin(w * t_s);
    const double c = std::cos(w * t_s);
    const MotionPoint f = fade(t_s);
    return {centre_m_ + amplitude_m_ * f.x_m * s, amplitude_m_ * (f.v_mps * s + f.x_m * w * c),
            amplitude_m_ * (f.a_mps2 * s + 2.0 * f.v_mps * w * c - f.x_m * w * w * s)};
  }

 private:
  MotionPoint fade(double t_s) const {
    const double u = t_s / period_s_;
    const double left = static_cast<double>(cycles_) - u;
    if (u >= 1.0 && left >= 1.0) return {1.0, 0.0, 0.0};
    const bool out = u >= 1.0;
    const MotionPoint q = quintic(std::clamp(out ? left : u, 0.0, 1.0));
    return {q.x_m, (out ? -1.0 : 1.0) * q.v_mps / period_s_, q.a_mps2 / (period_s_ * period_s_)};
  }

  double centre_m_;
  double amplitude_m_;
  double period_s_;
  int cycles_;
};

}  // namespace

std::unique_ptr<Segment> make_dwell(double x_m, double duration_s) {
  if (!(duration_s >= 0.0)) throw std::invalid_argument("dwell: negative duration");
  return std::make_unique<Dwell>(x_m, duration_s);
}

std::unique_ptr<Segment> make_jerk_limited_move(double from_m, double to_m, const MoveLimits& limits) {
  if (!(limits.velocity_mps > 0.0 && limits.acceleration_mps2 > 0.0 && limits.jerk_mps3 > 0.0)) {
    throw std::invalid_argument("move: limits must be positive");
  }
  return std::make_unique<JerkLimitedMove>(from_m, to_m, limits);
}

std::unique_ptr<Segment> make_quintic_move(double from_m, double to_m, double peak_velocity_mps) {
  if (!(peak_velocity_mps > 0.0)) throw std::invalid_argument("move: peak velocity must be positive");
  return std::make_unique<QuinticMove>(from_m, to_m, peak_velocity_mps);
}

std::unique_ptr<Segment> make_sine(double centre_m, double amplitude_m, double frequency_Hz, int cycles) {
  if (!(frequency_Hz > 0.0) || cycles < 2)
    throw std::invalid_argument("sine: needs frequency > 0, cycles >= 2");
  return std::make_unique<Sine>(centre_m, amplitude_m, frequency_Hz, cycles);
}

}  // namespace slipstack::sim
