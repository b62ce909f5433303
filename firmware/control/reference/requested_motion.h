// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/controller.h"
#include "firmware/control/reference/plan_handshake.h"

namespace slipstack {

/// Searches, moves, changes of velocity and halts of the axis, each asked for once: what the tick does not
/// take over in time is planned again, from where the axis is by then. Works in the main loop; O(1), and at
/// most one plan a call.
class RequestedMotion {
 public:
  explicit RequestedMotion(Controller& controller) : controller_(controller) {}

  // Each: kOk, or why there is no such trajectory from this motion; kBeyondRange may pass when the axis has
  // braked, and stays requested.

  /// Moves in this direction (1 or -1) until something else is requested.
  PlanStatus search(std::int32_t direction, const MotionLimits& limits) {
    direction_ = direction;
    limits_ = limits;
    return request(Request::kSearch);
  }
  /// Moves to these counts.
  PlanStatus move_to(std::int32_t counts, const MotionLimits& limits) {
    target_ = counts;
    limits_ = limits;
    return request(Request::kMove);
  }
  /// Changes to this velocity, counts per tick, and keeps it as far as the range of the axis allows.
  PlanStatus run(float velocity, const MotionLimits& limits) {
    velocity_ = velocity;
    limits_ = limits;
    return request(Request::kRun);
  }
  /// To rest.
  PlanStatus halt(const MotionLimits& limits) {
    limits_ = limits;
    return request(Request::kHalt);
  }
  void forget() { request_ = Request::kNone; }

  /// In every pass of the main loop: whether the tick has missed what was requested, or never had it.
  bool missed() {
    if (request_ == Request::kNone) return false;
    const PlanHandshake::State plan = handshake_.of(controller_.reference());
    if (plan == PlanHandshake::State::kTaken) request_ = Request::kNone;
    return plan == PlanHandshake::State::kMissed;
  }
  /// After that: the tick will take over what was requested, and has not yet.
  bool waits() const { return request_ != Request::kNone; }
  /// Then: the same once more.
  PlanStatus again() { return request(request_); }

  /// Nothing is requested, and the reference rests.
  bool at_rest() const { return request_ == Request::kNone && controller_.reference().idle(); }

 private:
  enum class Request : std::uint8_t { kNone, kSearch, kHalt, kMove, kRun };

  PlanStatus request(Request what) {
    request_ = what;
    handshake_.begin(controller_.reference());
    const PlanStatus status = plan();
    if (status == PlanStatus::kOk || status == PlanStatus::kBusy) return PlanStatus::kOk;
    if (status != PlanStatus::kBeyondRange) request_ = Request::kNone;
    return status;
  }
  PlanStatus plan() {
    switch (request_) {
      case Request::kSearch:
        return controller_.search(direction_, limits_);
      case Request::kMove:
        return controller_.move_to(target_, limits_);
      case Request::kRun:
        return controller_.run(velocity_, limits_);
      default:
        return controller_.halt(limits_);
    }
  }

  Controller& controller_;
  Request request_ = Request::kNone;
  std::int32_t direction_ = 0;
  std::int32_t target_ = 0;
  float velocity_ = 0.0F;
  MotionLimits limits_;
  PlanHandshake handshake_;
};

}  // namespace slipstack
