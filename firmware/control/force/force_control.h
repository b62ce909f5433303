// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/bounds/torque_bounds.h"
#include "firmware/control/control_output.h"
#include "firmware/control/current/current_command.h"
#include "firmware/control/force/excitation.h"
#include "firmware/control/parameters/control_set.h"
#include "firmware/control/supervision/command_box.h"
#include "firmware/control/tick_history.h"

namespace slipstack {

/// The force of each mode and the current that makes it: state estimate, feed-forward, feedback, limits
/// (docs/control.md). A tick steps the model, then one of the modes.
class ForceControl {
 public:
  /// What a tick goes by, and what it makes.
  struct Tick {
    const ControlSet& set;
    const MotionBounds& bounds;
    const Command& command;
    const TickHistory& history;
    TickHistory::Entry& entry;  ///< of this tick in it
    ControlOutput& out;
    std::uint32_t number;  ///< of the tick
    std::int32_t counts;
    float largest_A;  ///< what may be commanded now
    bool braking;     ///< the reference brakes
    bool fade;        ///< the wanted force may step, since parameters or the mode have changed
  };

  /// The force of the model where the reference is, with the dry friction at this level; `place` says where
  /// on the rail that is.
  float step_model(ControlSet& set, const ReferencePoint& at, float level, const PositionReference& place) {
    return feedforward_.step(set.model, set.scales, at, level, place);
  }
  /// Before it: where the hysteresis is. `follows`: the reference lies where the axis is.
  void observe(const ControlSet& set, const ReferencePoint& at, std::int32_t counts, bool follows) {
    feedforward_.observe(set.scales, at, counts, estimate_, follows);
  }
  /// What TickHistory keeps for the main loop; without a word on the level.
  TickHistory::Residual note() const {
    return {.dry_N = feedforward_.dry_N(), .place = feedforward_.place()};
  }

  // ---- the modes; false: the force is not finite, and no current was set ----

  /// Power stage off: the hysteresis follows the axis.
  void step_off(const Tick& tick) {
    expected_mps2_ = 0.0F;
    step_estimate(tick);
    publish(tick, tick.entry.point);
    tick.out.feedback_N = 0.0F;
    tick.out.current_A = 0.0F;
  }

  /// The axis follows the reference.
  [[gnu::always_inline]] bool step_position(const Tick& tick) {
    const ControlSet& set = tick.set;
    step_estimate(tick);
    take_correction(set);
    const ReferencePoint& now =
        tick.history.behind(tick.number, tick.history.lead_within(tick.number, set.lead));
    publish(tick, now);
    ControlOutput& out = tick.out;
    out.feedback_N = feedback_.step(set.feedback, now, out.position_error_m, estimate_.velocity_mps());
    const float disturbance_N = set.disturbance_kg * estimate_.disturbance_mps2();
    Force force;
    if (!apply(tick, out.feedforward_N + out.feedback_N - disturbance_N, force)) return false;
    expect(tick, now, force);
    feedback_.integrate(set.feedback, force.applied_N, force.wanted_N);
    note_residual(tick, now);
    return true;
  }

  /// As step_position(), and the loop is excited, without a word on the level of the friction. The estimate
  /// does not expect the excitation: it enters the loop as a disturbance of the axis would.
  [[gnu::always_inline]] bool step_excited(const Tick& tick, Excitation& excitation) {
    const ControlSet& set = tick.set;
    step_estimate(tick);
    const ReferencePoint& now =
        tick.history.behind(tick.number, tick.history.lead_within(tick.number, set.lead));
    publish(tick, now);
    ControlOutput& out = tick.out;
    const float added = excitation.step(now, out.position_error_m);
    const float added_N = added * excitation.force_share();
    const float error_m = out.position_error_m + added * excitation.position_share();
    out.feedback_N = feedback_.step(set.feedback, now, error_m, estimate_.velocity_mps());
    const float disturbance_N = set.disturbance_kg * estimate_.disturbance_mps2();
    Force force;
    if (!apply(tick, out.feedforward_N + out.feedback_N - disturbance_N + added_N, force)) return false;
    expect(tick, now, {force.wanted_N, force.applied_N - added_N});
    feedback_.integrate(set.feedback, force.applied_N, force.wanted_N);
    return true;
  }

  /// The force is commanded, within `bound`; `range`: where the axis may be.
  [[gnu::always_inline]] bool step_torque(const Tick& tick, TorqueBounds& bound, const PositionRange& range) {
    const ControlSet& set = tick.set;
    follow_axis(tick);
    Force force;
    if (!apply(tick, bounded(tick), force)) return false;
    expect(tick, tick.entry.point, force);
    bound.look_ahead(range, tick.bounds.stopping,
                     {tick.counts, estimate_.velocity_mps() * set.counts_per_mps,
                      expected_mps2_ / set.mps2_per_count, tick.command.target_N + tick.command.offset_N});
    return true;
  }

  /// The force is that of the direction check. An offset is for an axis that is known.
  bool step_push(const Tick& tick, float push_N) {
    follow_axis(tick);
    Force force;
    if (!apply(tick, push_N - tick.command.offset_N, force)) return false;
    expect(tick, tick.entry.point, force);
    return true;
  }

  // ---- between the modes ----

  /// Another mode: the feedback begins anew; `off`: without current.
  void change_mode(bool off) {
    if (off) current_.reset();
    feedback_.reset();
  }
  /// The reference begins anew in this tick, where the axis is and as it moves: the last step, right to a
  /// count, bounds the estimate, which lags behind a push. Returns the velocity, counts per tick.
  float begin_anew(const ControlSet& set, std::int32_t last_step) {
    const auto step = static_cast<float>(last_step);
    const float velocity =
        approx::clamp(estimate_.velocity_mps() * set.counts_per_mps, step - 1.0F, step + 1.0F);
    estimate_.correct_velocity(velocity * set.mps_per_count);
    feedback_.reset();
    current_.end_fade();
    return velocity;
  }
  /// What a value that is not finite may have reached.
  void forget(ControlSet& set) {
    estimate_.reset(estimate_.counts());
    set.forget_motion(estimate_.counts());
    feedforward_.start(set.scales, estimate_.counts());
  }
  /// The first parameters: the axis is here.
  void start(const ControlSet& set, std::int32_t counts) {
    estimate_.reset(counts);
    feedforward_.start(set.scales, counts);
  }

  const StateEstimate& estimate() const { return estimate_; }
  /// The current of the last tick.
  float last_A() const { return current_.last_A(); }

 private:
  struct Force {
    float wanted_N;
    float applied_N;  // what the limits of the current leave of it
  };

  // How the axis moves.
  void step_estimate(const Tick& tick) { estimate_.step(tick.set.estimate, tick.counts, expected_mps2_); }

  // The reference follows the axis.
  [[gnu::always_inline]] void follow_axis(const Tick& tick) {
    step_estimate(tick);
    const ReferencePoint& now = tick.entry.point;
    publish(tick, now);
    tick.out.feedback_N = 0.0F;
    // Where the next tick should find the axis.
    tick.out.reference_counts = sum(now.counts, static_cast<std::int32_t>(now.velocity));
  }

  // What the observer changes in the friction leaves the force as it is: the disturbance that the estimate
  // sees is from now on one of the corrected model, and the integral gives up the rest.
  void take_correction(const ControlSet& set) {
    const float corrected_N = feedforward_.corrected_N();
    feedback_.give_up(set.uncompensated_share * corrected_N);
    estimate_.expect_less(set.per_mass_kg * corrected_N);
  }

  // The commanded force, with the share of the friction that is compensated, within the velocity limit.
  float bounded(const Tick& tick) const {
    const float force_N = tick.command.target_N + tick.set.torque_share * tick.out.feedforward_N;
    return TorqueBounds::within_velocity(tick.set, tick.bounds.velocity_mps, estimate_.velocity_mps(),
                                         force_N, tick.out.limits);
  }

  void publish(const Tick& tick, const ReferencePoint& at) {
    ControlOutput& out = tick.out;
    out.reference_counts = at.counts;
    out.position_error_m = Feedback::error_m(tick.set.feedback, at, estimate_);
    out.velocity_mps = estimate_.velocity_mps();
    out.residual_N = -tick.set.mass_kg * estimate_.disturbance_mps2();
  }

  // Offset, fading and limits; the current that gives the force.
  [[gnu::always_inline]] bool apply(const Tick& tick, float force_N, Force& force) {
    const ControlSet& set = tick.set;
    const float asked_N = force_N + tick.command.offset_N;
    if (tick.fade) current_.begin_fade(asked_N, !tick.out.driving);
    force.wanted_N = current_.faded(set, asked_N);
    const float wanted_A = force.wanted_N * set.A_per_N;
    if (!approx::is_finite(wanted_A)) return false;
    tick.out.current_A = current_.limited(set, tick.largest_A, wanted_A, tick.out.limits);
    if (tick.braking) tick.out.limits |= kLimitReference;
    force.applied_N = tick.out.current_A * set.axis.motor_constant_N_per_A;
    return true;
  }

  // The acceleration that the state estimate shall expect: that of the reference, and what a force beyond the
  // model adds.
  void expect(const Tick& tick, const ReferencePoint& at, const Force& force) {
    const float excess_N = force.applied_N - tick.out.feedforward_N;
    expected_mps2_ = at.acceleration * tick.set.mps2_per_count + excess_N * tick.set.per_mass_kg;
  }

  // What a tick says about the level of the friction, for the main loop: nothing where a limit is active or
  // the reference is near rest.
  void note_residual(const Tick& tick, const ReferencePoint& at) {
    if (tick.out.limits != 0) return;
    if (approx::absolute(at.velocity) <= tick.set.adaptation_counts) return;
    tick.entry.residual.residual_N = tick.out.residual_N;
  }

  StateEstimate estimate_;
  FeedForward feedforward_;
  Feedback feedback_;
  CurrentCommand current_;
  float expected_mps2_ = 0.0F;
};

}  // namespace slipstack
