// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "tests/bench/cyclic_position/reference_watch.h"
#include "tests/bench/real_time/lateness.h"
#include "tests/can/profile/homing_axis.h"

namespace slipstack::bench {

/// A stretch of the drive's own time: as many ticks as the master has in a period.
struct Stretch {
  static constexpr std::int64_t kTicks = 40;

  double square_error = 0.0;  ///< of following, m2, summed over the ticks
  double late_s = 0.0;        ///< of the drive's process, at most
  bool unlocked = false;      ///< the loop on SYNC had no lock, for a tick at least
};

/// What is known of a drive by looking into it. In memory that two processes share: the drive's writes it,
/// the other one reads it when that has ended.
struct Inside {
  Seen seen;
  Fault fault = Fault::kNone;  ///< the first one
  std::uint32_t bridged = 0, gaps = 0;
  double axis_mps = 0.0;                    ///< largest velocity of the axis
  double current_step_A = 0.0;              ///< largest change of the current in a tick
  double position_m = 0.0;                  ///< on the rail, at last
  Lateness turns;                           ///< of the drive's process
  std::array<Stretch, 20'000> stretches{};  ///< from the start on, 80 s
  bool real_time_scheduling = false;
  std::uint32_t frames_not_sent = 0;
  std::atomic<std::uint32_t> marks_wanted{0};  ///< by the other process: what is seen counts from here on
};

/// A drive on its axis, tick by tick.
class WatchedDrive {
 public:
  static constexpr double kStart_m = 0.2;

  explicit WatchedDrive(bool referenced) : axis_(kStart_m, referenced) { axis_.all(); }

  /// One tick and one turn of the main loop, so late. `next(frame)` takes what has come from the bus,
  /// `send(frame)` what goes to it.
  template <class Next, class Send>
  void tick(Inside& inside, double late_s, const Next& next, const Send& send) {
    CanFrame frame;
    while (next(frame)) axis_.master.send(frame);
    Controller& controller = axis_.loop->controller();
    if (const std::uint32_t wanted = inside.marks_wanted.load(); wanted != marks_) {
      marks_ = wanted;
      watch_.mark(controller);
      inside.axis_mps = inside.current_step_A = 0.0;
      inside.bridged = inside.gaps = 0;
      bridged_ = controller.cyclic_position().bridged();
      gaps_ = controller.cyclic_position().gaps();
    }
    const double before_A = current_A();
    Stretch& stretch = inside.stretches[std::min(static_cast<std::size_t>(++ticks_ / Stretch::kTicks),
                                                 inside.stretches.size() - 1)];
    stretch.late_s = std::max(stretch.late_s, late_s);
    axis_.loop->step();
    axis_.drive->after_tick();
    axis_.now_us += 100;
    axis_.poll();
    watch_.look(controller);
    inside.seen = watch_.seen;
    const auto error_m = static_cast<double>(controller.output().position_error_m);
    stretch.square_error += error_m * error_m;
    stretch.unlocked = stretch.unlocked || !controller.cyclic_position().clock().locked();
    if (inside.fault == Fault::kNone) inside.fault = controller.state().faults().latched();
    inside.bridged = controller.cyclic_position().bridged() - bridged_;
    inside.gaps = controller.cyclic_position().gaps() - gaps_;
    inside.axis_mps = std::max(inside.axis_mps, std::abs(axis_.loop->plant.velocity_mps()));
    inside.current_step_A = std::max(inside.current_step_A, std::abs(current_A() - before_A));
    inside.position_m = axis_.loop->plant.position_m();
    while (axis_.master.receive(frame)) send(frame);
  }

  can::HomingAxis& axis() { return axis_; }
  const AxisParameters& parameters() { return axis_.loop->controller().parameters().axis; }

 private:
  double current_A() const {
    return axis_.loop->motor.enabled ? static_cast<double>(axis_.loop->motor.set_point_A) : 0.0;
  }

  can::HomingAxis axis_;
  ReferenceWatch watch_;
  std::int64_t ticks_ = 0;
  std::uint32_t marks_ = 0;
  std::uint32_t bridged_ = 0, gaps_ = 0;
};

}  // namespace slipstack::bench
