// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "firmware/control/controller.h"
#include "tests/loop/axis_loop.h"

// An eye on every step of the reference.
namespace slipstack::bench {

/// What the reference did, in SI units.
struct Seen {
  double velocity_mps = 0.0;       ///< largest difference of two positions
  double acceleration_mps2 = 0.0;  ///< largest difference of two velocities
  double jerk_mps3 = 0.0;          ///< largest difference of two accelerations
  double error_m = 0.0;            ///< largest following error
  double square_error = 0.0;
  std::int64_t ticks = 0;
  double rms_error_m() const {
    return std::sqrt(square_error / static_cast<double>(std::max<std::int64_t>(ticks, 1)));
  }
};

class ReferenceWatch {
 public:
  /// Differences count from here on.
  void mark(const Controller& controller) {
    const ReferencePoint& point = controller.history().point(controller.ticks());
    last_ = point.counts;
    last_fraction_ = static_cast<double>(point.fraction);
    if (controller.reference().standing()) last_step_ = last_change_ = 0.0;
    seen = {};
  }

  /// After each tick.
  void look(Controller& controller) {
    // What the tick was led by; the generator is one tick ahead, where the next segment of a plan may begin.
    const ReferencePoint& point = controller.history().point(controller.ticks());
    const auto fraction = static_cast<double>(point.fraction);
    const double step = static_cast<double>(difference(point.counts, last_)) + fraction - last_fraction_;
    const double per_tick =
        static_cast<double>(controller.parameters().axis.encoder_resolution_m) / loop::kTick_s;
    seen.velocity_mps = std::max(seen.velocity_mps, std::abs(step) * per_tick);
    seen.acceleration_mps2 =
        std::max(seen.acceleration_mps2, std::abs(step - last_step_) * per_tick / loop::kTick_s);
    const double change = step - last_step_;
    seen.jerk_mps3 = std::max(seen.jerk_mps3,
                              std::abs(change - last_change_) * per_tick / (loop::kTick_s * loop::kTick_s));
    last_change_ = change;
    const auto error_m = static_cast<double>(controller.output().position_error_m);
    seen.error_m = std::max(seen.error_m, std::abs(error_m));
    seen.square_error += error_m * error_m;
    ++seen.ticks;
    last_ = point.counts;
    last_fraction_ = fraction;
    last_step_ = step;
  }

  Seen seen;

 private:
  std::int32_t last_ = 0;
  double last_fraction_ = 0.0;
  double last_step_ = 0.0;
  double last_change_ = 0.0;
};

}  // namespace slipstack::bench
