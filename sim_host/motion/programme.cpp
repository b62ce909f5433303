// SPDX-License-Identifier: Apache-2.0
#include "sim_host/motion/programme.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace slipstack::sim {

void MotionProgramme::append(std::unique_ptr<Segment> segment) {
  starts_s_.push_back(end_s_);
  end_s_ += segment->duration_s();
  segments_.push_back(std::move(segment));
}

MotionPoint MotionProgramme::at(double t_s) const {
  if (segments_.empty()) return {};
  const auto next = std::upper_bound(starts_s_.begin() + 1, starts_s_.end(), t_s);
  const std::size_t i = static_cast<std::size_t>(next - starts_s_.begin()) - 1;
  return segments_[i]->at(std::clamp(t_s - starts_s_[i], 0.0, segments_[i]->duration_s()));
}

namespace {

// Joins segments and keeps the position that has been reached.
class Composer {
 public:
  Composer(const Axis& axis, const ProgrammeOptions& options, Rng& rng)
      : axis_(axis), options_(options), rng_(rng), margin_m_(0.03 * axis.stroke_m), x_m_(random_place()) {
    brisk_ = {std::max(rng.uniform(0.08, 0.2), 5.0 * axis.stroke_m / options.seconds), rng.uniform(1.0, 2.5),
              rng.uniform(30.0, 120.0)};
  }

  void loops(double seconds) {
    const double travel_m = axis_.curve.travel_m();
    const double smallest_m = options_.smallest_loop_m > 0.0 ? options_.smallest_loop_m : 0.35 * travel_m;
    const double largest_m =
        options_.largest_loop_m > 0.0 ? options_.largest_loop_m : rng_.uniform(2.0, 4.0) * travel_m;
    const int places = std::clamp(static_cast<int>(std::lround(seconds / 3.5)), 2, 5);
    const int steps = static_cast<int>(4 + rng_.below(3));
    const int cycles = static_cast<int>(3 + rng_.below(2));  // first and last are fades
    // Time needed for a place beside its sines: the move there and a pause.
    const double sine_s = std::max(0.8, seconds / places - 0.4 * axis_.stroke_m / brisk_.velocity_mps - 0.2);
    const double frequency_Hz = std::clamp(steps * cycles / sine_s, 1.0, 12.0);
    for (int place = 0; place < places; ++place) {
      move_to(random_place(), brisk_);
      dwell(rng_.uniform(0.1, 0.3));
      for (int step = 0; step < steps; ++step) {
        const double share = static_cast<double>(step) / (steps - 1);
        const double amplitude_m = smallest_m * std::pow(largest_m / smallest_m, share);
        programme_.append(make_sine(x_m_, amplitude_m, frequency_Hz * rng_.uniform(0.9, 1.1), cycles));
      }
    }
  }

  void traverses(double until_s) {
    const int speeds = static_cast<int>(4 + rng_.below(2));
    const double slowest = rng_.log_uniform(3e-3, 6e-3);
    const double fastest = std::min(rng_.log_uniform(0.1, 0.2), 1.2 * axis_.stroke_m);
    // The segments before may have taken longer than their share; the traverses are shortened accordingly.
    for (int i = 0; i < speeds; ++i) {
      const double speed = slowest * std::pow(fastest / slowest, static_cast<double>(i) / (speeds - 1));
      strokes_at(speed, std::max(0.7, (until_s - programme_.duration_s()) / (speeds - i)));
    }
  }

  void moves(double until_s) {
    const MoveLimits most = {std::min(rng_.uniform(0.3, 0.8), 4.0 * axis_.stroke_m), rng_.uniform(4.0, 10.0),
                             rng_.log_uniform(150.0, 900.0)};
    while (programme_.duration_s() < until_s) {
      const double share = rng_.uniform(0.4, 1.0);
      MoveLimits limits = {share * most.velocity_mps, most.acceleration_mps2, most.jerk_mps3};
      double target_m = random_place();
      if (std::fabs(target_m - x_m_) < 0.1 * axis_.stroke_m) target_m = axis_.stroke_m - target_m;
      if (rng_.chance(0.3)) {
        // A quintic's peak acceleration is 3.08·v²/distance.
        const double peak = std::sqrt(most.acceleration_mps2 * std::fabs(target_m - x_m_) / 3.08);
        append(make_quintic_move(x_m_, target_m, std::max(1e-3, std::min(limits.velocity_mps, peak))),
               target_m);
      } else {
        move_to(target_m, limits);
      }
      dwell(rng_.uniform(0.05, 0.25));
    }
  }

  void dwell(double seconds) { programme_.append(make_dwell(x_m_, seconds)); }

  MotionProgramme take() { return std::move(programme_); }

 private:
  double random_place() { return rng_.uniform(margin_m_, axis_.stroke_m - margin_m_); }

  void append(std::unique_ptr<Segment> segment, double target_m) {
    programme_.append(std::move(segment));
    x_m_ = target_m;
  }

  void move_to(double target_m, const MoveLimits& limits) {
    append(make_jerk_limited_move(x_m_, target_m, limits), target_m);
  }

  // To and fro at one speed for about `seconds`, over as much of the stroke as that allows.
  void strokes_at(double speed, double seconds) {
    const bool quintic = rng_.chance(0.5);
    seconds = std::max(0.5, seconds - 0.5 * axis_.stroke_m / brisk_.velocity_mps - 0.2);  // going there
    const double usable_m = axis_.stroke_m - 2.0 * margin_m_;
    const double per_way = quintic ? 1.875 : 1.15;  // duration of a traverse over distance/speed
    double way_m = std::min(usable_m, speed * seconds / (2.0 * per_way));
    const int pairs = std::max(1, static_cast<int>(std::lround(seconds * speed / (2.0 * per_way * way_m))));
    way_m = std::min(usable_m, seconds * speed / (2.0 * per_way * pairs));
    const double low_m = margin_m_ + (usable_m - way_m) * rng_.uniform();
    const double ramp_s = rng_.uniform(0.15, 0.4) * std::min(1.0, way_m / speed);
    const MoveLimits limits = {speed, speed / ramp_s, 4.0 * speed / (ramp_s * ramp_s)};
    bool at_low = std::fabs(x_m_ - low_m) < std::fabs(x_m_ - (low_m + way_m));
    move_to(at_low ? low_m : low_m + way_m, brisk_);
    dwell(rng_.uniform(0.05, 0.15));
    for (int i = 0; i < 2 * pairs; ++i) {
      at_low = !at_low;
      const double target_m = at_low ? low_m : low_m + way_m;
      if (quintic) {
        append(make_quintic_move(x_m_, target_m, speed), target_m);
      } else {
        move_to(target_m, limits);
      }
    }
    dwell(rng_.uniform(0.05, 0.15));
  }

  const Axis& axis_;
  const ProgrammeOptions& options_;
  Rng& rng_;
  double margin_m_;
  double x_m_;
  MoveLimits brisk_{};
  MotionProgramme programme_;
};

}  // namespace

MotionProgramme make_test_programme(const Axis& axis, const ProgrammeOptions& options, Rng& rng) {
  if (!(options.seconds >= 8.0)) throw std::invalid_argument("a test programme needs at least 8 s");
  Composer composer(axis, options, rng);
  composer.dwell(0.2);
  composer.loops(0.27 * options.seconds);
  composer.traverses(0.72 * options.seconds);
  composer.moves(options.seconds - 0.2);
  composer.dwell(0.2);
  return composer.take();
}

}  // namespace slipstack::sim
