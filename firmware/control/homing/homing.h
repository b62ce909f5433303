// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/controller.h"
#include "firmware/control/homing/homing_methods.h"
#include "firmware/control/homing/homing_switches.h"
#include "firmware/control/reference/requested_motion.h"

namespace slipstack {

/// What homing goes by.
struct HomingSettings {
  const HomingMethod* method = nullptr;  ///< null: none
  MotionLimits fast;                     ///< while a switch is searched
  MotionLimits slow;                     ///< while the home position is searched, and against an end stop
  std::int32_t home_offset = 0;          ///< counts from the home position to position zero (607Ch)
  std::uint32_t timeout_ticks = 0;       ///< of all of it
  float end_stop_A = 0.0F;               ///< this much for so long is an end stop
  std::uint32_t end_stop_ticks = 0;
};

/// Finds the home position by a table of steps (homing_methods.h), and sets position zero by it. Works in the
/// main loop: it plans the moves; the tick notes the counts of the event that was armed (PositionLatch), so
/// that the main loop's time is in no position. Afterwards the axis rests at the home position, but beside a
/// limit switch it stays where it came to rest.
class Homing {
 public:
  enum class State : std::uint8_t {
    kNotStarted,  ///< or interrupted
    kRunning,
    kAttained,  ///< position zero is set, the axis still moves to the home position
    kDone,
    kError,  ///< no switch where one should be, a limit switch in the way, or out of time
  };

  explicit Homing(Controller& controller)
      : controller_(controller), switches_(controller), motion_(controller) {}

  State state() const { return state_; }
  bool running() const { return state_ == State::kRunning || state_ == State::kAttained; }

  /// Begins; the axis may move. What the position was is no longer known, until the home position is found.
  void start(const HomingSettings& settings) {
    settings_ = settings;
    state_ = State::kRunning;
    reversed_ = false;
    began_ = controller_.ticks();
    was_referenced_ = controller_.position().referenced();
    if (settings_.method == nullptr) return fail();
    switches_.use(*settings_.method);
    if (!switches_.wired()) return fail();
    controller_.position().give_up();
    const HomingMethod& method = *settings_.method;
    if (method.sensor == HomingMethod::Sensor::kNone) {
      if (method.index == 0) return found(controller_.measured_counts());
      return search_index();
    }
    direction_ = method.search;
    if (method.sensor == HomingMethod::Sensor::kCodedMarks) return search_marks();
    if (method.sensor == HomingMethod::Sensor::kEndStop) {
      pressed_at_ = began_;
      return go(Phase::kPress, direction_, settings_.slow);
    }
    if (switches_.on_switch()) return leave();
    go(Phase::kSearch, direction_, settings_.fast);
  }

  /// The axis halts; there is no home position. Not after the end.
  void interrupt() {
    if (!running()) return;
    give_up(State::kNotStarted);
    if (controller_.state().driving()) halt();
  }
  /// Another mode is in force, or the axis is no longer enabled.
  void reset() {
    if (running()) give_up(State::kNotStarted);
    state_ = State::kNotStarted;
    motion_.forget();
  }

  /// Running, and by a method that needs the axis to be enabled.
  bool moves_the_axis() const {
    return running() && (settings_.method->search != 0 || settings_.method->index != 0);
  }

  /// In every pass of the main loop while homing is the mode. O(1), and at most one plan.
  void step() {
    if (motion_.missed()) requested(motion_.again());
    if (state_ == State::kAttained && at_rest()) state_ = State::kDone;
    if (state_ != State::kRunning) return;
    if (controller_.ticks() - began_ > settings_.timeout_ticks) return fail();
    if (phase_ == Phase::kSetZero) return set_zero();
    if (moves() && (at_rest() || (switches_.limit(direction_) && !limit_is_reason()))) return fail();
    switch (phase_) {
      case Phase::kSearch:
        return search();
      case Phase::kStopOnSwitch:
        if (!at_rest()) return;
        if (switches_.on_switch()) return leave();
        direction_ = -direction_;  // passed over
        return go(Phase::kBack, direction_, settings_.slow);
      case Phase::kBack:
        if (switches_.on_switch()) stop(Phase::kStopOnSwitch);
        return;
      case Phase::kLeave:
        if (controller_.latch().taken()) stop(Phase::kStopBesideSwitch);
        return;
      case Phase::kStopBesideSwitch:
        if (at_rest()) enter();
        return;
      case Phase::kLast:
        if (controller_.latch().taken()) found(controller_.latch().counts());
        return;
      case Phase::kMarks:
        return follow_marks();
      case Phase::kPress:
        return press();
      case Phase::kSetZero:
        return;
    }
  }

 private:
  using Sensor = HomingMethod::Sensor;
  using Event = PositionLatch::Event;
  enum class Phase : std::uint8_t {
    kSearch,            ///< fast, towards the switch
    kStopOnSwitch,      ///< it was seen
    kBack,              ///< slowly back to it: the axis went past
    kLeave,             ///< slowly off the switch, not the last step
    kStopBesideSwitch,  ///< before it is entered again
    kLast,              ///< slowly to the home position
    kMarks,             ///< slowly past coded marks
    kPress,             ///< slowly against the end stop
    kSetZero,           ///< the home position is known
  };

  // ---- the steps ----

  // A limit switch on the way to a home switch turns the search round, once.
  void search() {
    if (switches_.on_switch()) return stop(Phase::kStopOnSwitch);
    if (!switches_.limit(direction_)) return;
    reversed_ = true;
    direction_ = -direction_;
    go(Phase::kSearch, direction_, settings_.fast);
  }

  void leave() {
    const HomingMethod& method = *settings_.method;
    direction_ = method.leave;
    const bool last = method.enter == 0;
    arm(last && method.index != 0 ? Event::kIndexAfterInactive : Event::kInactive);
    go(last ? Phase::kLast : Phase::kLeave, direction_, settings_.slow);
  }

  void enter() {
    direction_ = settings_.method->enter;
    arm(settings_.method->index != 0 ? Event::kIndexAfterActive : Event::kActive);
    go(Phase::kLast, direction_, settings_.slow);
  }
  void search_index() {
    direction_ = settings_.method->index;
    arm(Event::kIndex);
    go(Phase::kLast, direction_, settings_.slow);
  }

  void search_marks() {
    marks_.restart();
    marks_seen_ = controller_.history().index_number();
    go(Phase::kMarks, direction_, settings_.slow);
  }
  // A mark that the main loop did not see is missing. A limit switch turns the search round, once.
  void follow_marks() {
    if (switches_.limit(direction_)) {
      reversed_ = true;
      direction_ = -direction_;
      return search_marks();
    }
    const std::uint32_t passed = controller_.history().index_number() - marks_seen_;
    if (passed == 0) return;
    marks_seen_ += passed;
    if (passed > 1) marks_.restart();
    if (!marks_.passed(controller_.parameters().axis.reference.code(), controller_.history().index_counts()))
      return;
    controller_.position().set_scale_zero(marks_.zero());
    found(marks_.zero());
  }

  // More current than acceleration and friction need. Not by standstill: a stop of rubber gives way.
  void press() {
    if (approx::absolute(controller_.output().current_A) < settings_.end_stop_A)
      pressed_at_ = controller_.ticks();
    if (controller_.ticks() - pressed_at_ < settings_.end_stop_ticks) return;
    if (settings_.method->index != 0) return search_index();
    found(controller_.measured_counts());
  }

  // The home position is here.
  void found(std::int32_t counts) {
    controller_.latch().disarm();
    home_counts_ = counts;
    phase_ = Phase::kSetZero;
    if (controller_.state().driving()) {
      if (rests_at_home()) {
        move_to(counts);
      } else {
        halt();
      }
    }
    set_zero();
  }
  // As soon as the effects over position have faded.
  void set_zero() {
    if (controller_.position().set(sum(home_counts_, settings_.home_offset))) state_ = State::kAttained;
  }
  // Just beside a limit switch the next jerk would trigger it, and the zero of a scale may lie off the axis.
  bool rests_at_home() const {
    if (settings_.method->sensor == Sensor::kCodedMarks) return false;
    return !switches_.searches_limit() || settings_.method->index != 0;
  }

  void fail() {
    give_up(State::kError);
    if (controller_.state().driving()) halt();
  }
  // An absolute encoder knows its place all the same.
  void give_up(State state) {
    state_ = state;
    controller_.latch().disarm();
    const bool absolute = controller_.parameters().axis.reference.absolute_encoder;
    if (absolute && was_referenced_) controller_.position().set(controller_.position().origin());
  }

  // ---- switches ----

  // A limit switch that is active is no error where it is what is searched, or where the search turns round.
  bool limit_is_reason() const {
    if (phase_ == Phase::kSearch)
      return switches_.on_switch() || (settings_.method->sensor == Sensor::kHomeSwitch && !reversed_);
    if (phase_ == Phase::kMarks) return !reversed_;
    return phase_ == Phase::kBack && switches_.on_switch();
  }
  void arm(Event event) { controller_.latch().arm(event, switches_.mask()); }

  // ---- moves ----

  bool moves() const {
    return phase_ != Phase::kStopOnSwitch && phase_ != Phase::kStopBesideSwitch && phase_ != Phase::kSetZero;
  }
  bool at_rest() const { return motion_.at_rest(); }

  void go(Phase phase, std::int32_t direction, const MotionLimits& limits) {
    phase_ = phase;
    requested(motion_.search(direction, limits));
  }
  void stop(Phase phase) {
    phase_ = phase;
    halt();
  }
  void halt() { requested(motion_.halt(settings_.fast)); }
  void move_to(std::int32_t counts) { requested(motion_.move_to(counts, settings_.slow)); }
  void requested(PlanStatus status) {
    if (status == PlanStatus::kOk) return;
    motion_.forget();
    give_up(State::kError);
    controller_.reference().stop();
  }

  Controller& controller_;
  HomingSwitches switches_;
  RequestedMotion motion_;
  HomingSettings settings_;
  State state_ = State::kNotStarted;
  Phase phase_ = Phase::kSearch;
  CodedMarks marks_;
  std::uint32_t marks_seen_ = 0;  // of TickHistory::index_number()
  bool reversed_ = false;
  bool was_referenced_ = false;
  std::int32_t direction_ = 0;
  std::int32_t home_counts_ = 0;
  std::uint32_t began_ = 0;
  std::uint32_t pressed_at_ = 0;
};

}  // namespace slipstack
