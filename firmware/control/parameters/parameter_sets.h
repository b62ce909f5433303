// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <new>

#include "firmware/control/parameters/control_set.h"
#include "firmware/control/parameters/parameter_swap.h"

namespace slipstack {

/// The parameters that are in force and those that come next, with the user's bounds, which hold for both.
class ParameterSets {
 public:
  // ---- in the tick ----

  /// Begins it; true when new parameters came into force.
  bool begin_tick() { return sets_.begin_tick(); }
  ControlSet& active() { return sets_.active(); }
  const ControlSet& active() const { return sets_.active(); }
  std::uint32_t tick() const { return sets_.tick(); }

  // ---- outside the tick ----

  /// Checks and prepares new parameters; they come into force with the next tick or a later one. Refused
  /// parameters change nothing. `time_s`: since the start.
  ParameterStatus configure(const AxisParameters& axis, const ModelParameters& model, float time_s) {
    ControlSet* spare = sets_.spare();
    if (spare == nullptr) return ParameterStatus::kBusy;
    const AxisParameters& now = active().axis;
    const bool changed = axis.encoder_resolution_m != now.encoder_resolution_m || axis.tick_s != now.tick_s;
    if (active().valid && changed) return ParameterStatus::kFixedAtStart;
    const ParameterStatus status = spare->prepare(axis, model, user_bounds_);
    if (status != ParameterStatus::kOk) return status;
    spare->model.refresh(time_s + spare->drift_begin_s);
    exchange(*spare);
    return status;
  }
  /// The parameters themselves are the reason that configure() did nothing.
  static bool refused(ParameterStatus status) {
    return status != ParameterStatus::kOk && status != ParameterStatus::kBusy &&
           status != ParameterStatus::kFixedAtStart;
  }
  /// From the next tick on there are no parameters. False while another change is pending.
  bool withdraw() {
    ControlSet* spare = sets_.spare();
    if (spare == nullptr) return false;
    ::new (static_cast<void*>(spare)) ControlSet;  // in place: a copy would not fit the stack
    exchange(*spare);
    return true;
  }
  /// In every pass of the main loop: a change that a tick has missed.
  void poll() {
    if (sets_.pending()) sets_.arm();
  }
  bool change_pending() const { return sets_.pending(); }

  /// Bounds of motion beside those of the axis; in force from the next tick on.
  void bound(const UserBounds& user) {
    const std::uint32_t number = user_bounds_.number + 1;
    user_bounds_ = user;
    user_bounds_.number = number;
    sets_.each([this](ControlSet& set) { set.bound(user_bounds_); });
  }
  const UserBounds& user_bounds() const { return user_bounds_; }

 private:
  void exchange(ControlSet& spare) {
    spare.number = active().number + 1;
    sets_.arm();
  }

  ParameterSwap<ControlSet> sets_;
  UserBounds user_bounds_;
};

}  // namespace slipstack
