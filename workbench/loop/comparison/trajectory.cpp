// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/trajectory.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <utility>

#include "sim_host/log/draw.h"
#include "sim_host/motion/programme.h"

namespace slipstack::workbench {
namespace {

constexpr double kDwell_s = 0.3;

// What the motor can do with room for the feedback, but no more than a usual pick-and-place axis does.
sim::MoveLimits limits_of(const sim::Axis& axis) {
  const double spare_N = axis.current_limit_A * axis.motor_constant_N_per_A - 2.0 * axis.curve.saturation_N();
  const double acceleration_mps2 = std::clamp(0.4 * spare_N / axis.mass_kg, 0.5, 8.0);
  return {0.5, acceleration_mps2, acceleration_mps2 / 0.03};
}

// The direction changes, with or without a dwell in between.
void find_reversals(Trajectory& motion) {
  double before = 0.0;
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const double v = motion.points[i].v_mps;
    if (v == 0.0) continue;
    if (before * v < 0.0) motion.reversals.push_back(i);
    before = v;
  }
}

/// A programme that notes its moves.
class Composer {
 public:
  Composer(double start_m, double tick_s) : tick_s_(tick_s), at_m_(start_m) { dwell(); }

  void dwell() { programme_.append(sim::make_dwell(at_m_, kDwell_s)); }
  void sine(double amplitude_m, double frequency_Hz, int cycles) {
    programme_.append(sim::make_sine(at_m_, amplitude_m, frequency_Hz, cycles));
  }
  void there_and_back(double nominal_m, double length_m, const sim::MoveLimits& limits) {
    const double home_m = at_m_;
    for (const double target_m : {home_m + length_m, home_m}) {
      programme_.append(sim::make_jerk_limited_move(at_m_, target_m, limits));
      at_m_ = target_m;
      const auto end = static_cast<std::size_t>(std::ceil(programme_.duration_s() / tick_s_));
      moves_.push_back({nominal_m, end, static_cast<std::size_t>(kDwell_s / tick_s_)});
      dwell();
    }
  }
  Trajectory take() {
    Trajectory made =
        sampled([&](double t_s) { return programme_.at(t_s); }, programme_.duration_s(), tick_s_);
    made.moves = std::move(moves_);
    return made;
  }

 private:
  double tick_s_;
  double at_m_;
  sim::MotionProgramme programme_;
  std::vector<Trajectory::Move> moves_;
};

double turn_s(double radius_m) {
  // 0.3 m/s on the largest circle, half a second a turn on the others.
  return std::max(0.5, 2.0 * std::numbers::pi * radius_m / 0.3);
}

}  // namespace

Trajectory sampled(const std::function<sim::MotionPoint(double)>& motion, double duration_s, double tick_s) {
  Trajectory made;
  made.tick_s = tick_s;
  const auto count = static_cast<std::size_t>(std::floor(duration_s / tick_s));
  made.points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) made.points.push_back(motion(static_cast<double>(i) * tick_s));
  for (std::size_t i = 0; i + 1 < count; ++i)
    made.points[i].a_mps2 = (made.points[i + 1].v_mps - made.points[i].v_mps) / tick_s;
  find_reversals(made);
  return made;
}

Trajectory training_motion(const sim::Axis& axis, std::uint64_t seed, double seconds, double tick_s) {
  sim::Bench bench;
  bench.axis = axis;
  bench.programme.seconds = 16.0;
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  return sampled([&](double t_s) { return programme.at(t_s); }, std::min(seconds, programme.duration_s()),
                 tick_s);
}

Trajectory judged_motion(const sim::Axis& axis, double tick_s, bool brief) {
  const sim::MoveLimits limits = limits_of(axis);
  Composer composer(0.42 * axis.stroke_m, tick_s);
  composer.sine(5e-6, 4.0, 4);
  composer.sine(50e-6, 3.0, 4);
  composer.sine(1e-3, 2.0, 4);
  composer.dwell();
  if (!brief) {
    composer.sine(10e-3, 1.0, 3);
    composer.dwell();
    composer.there_and_back(10e-6, 10e-6, limits);
  }
  composer.there_and_back(1e-3, 1e-3, limits);
  if (!brief) {
    const double long_m = std::min(0.1, 0.5 * axis.stroke_m);
    composer.there_and_back(0.1, long_m, limits);
    composer.there_and_back(0.1, long_m, limits);
  }
  return composer.take();
}

Trajectory circle(const sim::Axis& axis, double radius_m, double tick_s, bool sine) {
  const double r = std::min(radius_m, 0.35 * axis.stroke_m);
  const double full = 2.0 * std::numbers::pi / turn_s(r);  // rad/s
  const double ramp_s = 2.0 * turn_s(r);                   // a turn long: the mean speed is half the full one
  const double middle_m = 0.5 * axis.stroke_m;
  const auto at = [&](double t_s) {
    // The angle's speed rises by 3u² − 2u³ over the ramp.
    const double u = std::min(t_s / ramp_s, 1.0);
    const double angle = full * (ramp_s * (u * u * u - 0.5 * u * u * u * u) + std::max(t_s - ramp_s, 0.0));
    const double w = full * u * u * (3.0 - 2.0 * u);
    const double dw = u < 1.0 ? full * 6.0 * u * (1.0 - u) / ramp_s : 0.0;
    const double s = r * std::sin(angle);
    const double c = r * std::cos(angle);
    return sine ? sim::MotionPoint{middle_m + s, c * w, c * dw - s * w * w}
                : sim::MotionPoint{middle_m + c, -s * w, -s * dw - c * w * w};
  };
  return sampled(at, ramp_s + 2.0 * turn_s(r), tick_s);
}

std::size_t circle_begin(const Trajectory& circle) {
  return circle.size() / 2;  // two turns' time of ramp, two turns
}

}  // namespace slipstack::workbench
