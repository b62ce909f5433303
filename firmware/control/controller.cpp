// SPDX-License-Identifier: Apache-2.0
#include "firmware/control/controller.h"

namespace slipstack {

Controller::Controller() = default;

ParameterStatus Controller::configure(const AxisParameters& axis, const ModelParameters& model) {
  const ParameterStatus status = sets_.configure(axis, model, upkeep_.time_s());
  if (ParameterSets::refused(status)) supervisor_.faults().parameters_refused();
  return status;
}

void Controller::poll() {
  sets_.poll();
  cyclic_position_.poll(ticks());
  watch_hunting();
  upkeep_.step(sets_, history_, position_, out_.driving);
  if (!position_.check_index(parameters().axis.reference)) inject(Fault::kIndexOffPlace);
  if (unseen_.follow(
          parameters().unseen, history_, [this] { return ticks(); }, moves_freely()))
    inject(Fault::kEncoderStands);
  if (load_.step(parameters(), ticks(), driving(), measured_A())) inject(Fault::kOverload);
}

void Controller::watch_hunting() {
  const ControlSet& set = parameters();
  auto drive = HuntingWatch::Drive::kNotFree;
  if (set.valid && moves_freely()) {
    if (mode_ == ControlMode::kPosition) drive = HuntingWatch::Drive::kPosition;
    if (mode_ == ControlMode::kTorque) drive = HuntingWatch::Drive::kTorque;
  }
  hunting_.follow(
      set.hunting, set.number, history_, [this] { return ticks(); }, drive);
  upkeep_.lower(hunting_.friction_share());
  sets_.active().compensate_disturbance(hunting_.disturbance_share());
}

void Controller::sense(const AnalogueReadings& readings) {
  const auto elapsed_s = static_cast<float>(ticks() - sensed_at_) * parameters().axis.tick_s;
  sensed_at_ = ticks();
  const Fault fault =
      parameters().valid ? analogue_.step(parameters().axis, readings, elapsed_s, driving()) : Fault::kNone;
  supervisor_.faults().hold(fault);
}

PlanStatus Controller::move_to(std::int32_t counts, const MotionLimits& limits) {
  return point_to_point_.move(reference_, counts, limits.and_within(bounds().motion), ramp(), range(),
                              position_.origin());
}

PlanStatus Controller::search(std::int32_t direction, const MotionLimits& limits) {
  return point_to_point_.search(reference_, direction, limits.and_within(bounds().motion), ramp());
}

PlanStatus Controller::run(float velocity, const MotionLimits& limits) {
  return point_to_point_.run(reference_, velocity, limits.and_within(bounds().motion), ramp(), range());
}

PlanStatus Controller::halt(const MotionLimits& limits) {
  return point_to_point_.halt(reference_, limits.and_within(bounds().motion), ramp());
}

Motion Controller::ahead(std::uint32_t lead) const {
  return reference_.predict(lead, ramp()).motion;
}

void Controller::bridge(EncoderReading& reading) {
  const PositionReferenceParameters& encoder = parameters().axis.reference;
  const FaultMonitor& monitor = supervisor_.faults().monitor();
  if (encoder.absolute_encoder)
    bridge_.step(reading, encoder.bridged_ticks, ticks(), monitor.last_counts(), monitor.last_step());
}

// ---- the tick, and the parts of it ----

const ControlOutput& Controller::step(const TickInputs& in) {
  const bool new_parameters = sets_.begin_tick();
  ControlSet& set = sets_.active();
  const std::int32_t counts = in.encoder.counts;
  if (new_parameters) begin_with(set, counts);
  inputs_ = DigitalInputs(in.digital);
  entry_ = &history_.entry(sets_.tick());
  entry_->reading = {counts, in.digital, force_.last_A()};
  if (latch_.armed()) [[unlikely]]
    latch_.step(inputs_, set.io, counts);
  const MotionBounds& bounds = set.bounds.read();
  out_.limits = 0;
  travel_.step(set.io, bounds, inputs_, counts, reference_, cyclic_position_, out_.limits);
  supervise(set, bounds, in);
  const ControlMode before = mode_;
  change_mode(supervisor_.mode(mode_, reference_, out_.limits));
  const bool fade = new_parameters || (mode_ != before && before != ControlMode::kOff) || excitation_.left();
  bool finite = true;
  switch (mode_) {
    case ControlMode::kOff:
      stay_off(set, bounds, counts);
      break;
    case ControlMode::kPosition:
      finite = excitation_.takes_part() ? control_excited(set, bounds, counts)
                                        : control_position(set, bounds, counts, fade);
      break;
    case ControlMode::kTorque:
      finite = control_torque(set, bounds, counts, fade);
      break;
    case ControlMode::kPush:
      finite = push(set, bounds, counts, fade);
      break;
  }
  if (!finite) [[unlikely]]
    stop_not_finite(set);
  out_.driving = mode_ != ControlMode::kOff;
  return out_;
}

inline void Controller::begin_with(const ControlSet& set, std::int32_t counts) {
  load_.begin(set.axis.current_limit_A);
  const bool starts = set.valid && !started_;
  started_ = set.valid;
  supervisor_.begin_with(set, starts, counts);
  if (!starts) return;
  force_.start(set, counts);
  position_.start(set.axis.reference);
}

[[gnu::noinline]] inline void Controller::supervise(ControlSet& set, const MotionBounds& bounds,
                                                    const TickInputs& in) {
  const std::int32_t counts = in.encoder.counts;
  if (!set.valid) set.start_counts = counts;
  const bool anew =
      supervisor_.step(set, bounds, in, inputs_, sets_.tick(), out_, force_.last_A(), position_, reference_);
  if (!anew && !(follows_axis(mode_) && state().braking())) return;
  history_.begin_anew(sets_.tick());
  const std::int32_t last_step = supervisor_.faults().monitor().last_step();
  reference_.follow(counts, force_.begin_anew(set, last_step));
}

inline void Controller::change_mode(ControlMode mode) {
  if (mode == mode_) return;
  // Out of torque mode the axis is braked from its own velocity, then holds its position. In a stop the
  // supervisor does that.
  if (follows_axis(mode_) && mode == ControlMode::kPosition && !state().braking()) reference_.stop();
  force_.change_mode(mode == ControlMode::kOff);
  mode_ = mode;
}

inline void Controller::stay_off(ControlSet& set, const MotionBounds& bounds, std::int32_t counts) {
  reference_.hold(counts);
  if (excitation_.takes_part()) [[unlikely]]
    excitation_.leave();
  step_model(set, bounds, counts);
  force_.step_off(tick(set, bounds, counts, false));
}

[[gnu::always_inline]] inline bool Controller::control_position(ControlSet& set, const MotionBounds& bounds,
                                                                std::int32_t counts, bool fade) {
  step_model(set, bounds, counts);
  return force_.step_position(tick(set, bounds, counts, fade));
}

[[gnu::noinline]] inline bool Controller::control_excited(ControlSet& set, const MotionBounds& bounds,
                                                          std::int32_t counts) {
  const bool ends = reference_.braking() || reference_.plan_waits() || !excitation_.running();
  if (ends) excitation_.leave();
  entry_->point = reference_.next(supervisor_.ramp(bounds));
  entry_->residual = force_.note();
  return force_.step_excited(tick(set, bounds, counts, ends), excitation_);
}

inline bool Controller::control_torque(ControlSet& set, const MotionBounds& bounds, std::int32_t counts,
                                       bool fade) {
  if (excitation_.takes_part()) [[unlikely]]
    excitation_.leave();
  follow_axis(set, counts);
  step_model(set, bounds, counts);
  return force_.step_torque(tick(set, bounds, counts, fade), supervisor_.torque_bounds(), travel_.range());
}

[[gnu::noinline]] inline bool Controller::push(ControlSet& set, const MotionBounds& bounds,
                                               std::int32_t counts, bool fade) {
  follow_axis(set, counts);
  step_model(set, bounds, counts);
  return force_.step_push(tick(set, bounds, counts, fade), supervisor_.check().force_N());
}

inline void Controller::follow_axis(const ControlSet& set, std::int32_t counts) {
  reference_.follow(counts, force_.estimate().velocity_mps() * set.counts_per_mps);
}

inline void Controller::step_model(ControlSet& set, const MotionBounds& bounds, std::int32_t counts) {
  const std::uint32_t tick = sets_.tick();
  // The first tick with current holds the axis where it is.
  const bool streamed = out_.driving && mode_ == ControlMode::kPosition && !state().braking();
  TickHistory::Entry& entry = *entry_;
  if (streamed && cyclic_position_.step(tick)) {
    entry.point = reference_.track(cyclic_position_.point(), bounds.tracking);
  } else {
    entry.point = reference_.next(supervisor_.ramp(bounds));
  }
  out_.level = upkeep_.level();
  force_.observe(set, entry.point, counts, mode_ != ControlMode::kPosition);
  out_.feedforward_N = force_.step_model(set, entry.point, out_.level, position_);
  entry.residual = force_.note();
}

inline ForceControl::Tick Controller::tick(const ControlSet& set, const MotionBounds& bounds,
                                           std::int32_t counts, bool fade) {
  return {set,
          bounds,
          supervisor_.command().read(),
          history_,
          *entry_,
          out_,
          sets_.tick(),
          counts,
          load_.largest_A(),
          reference_.braking(),
          fade};
}

inline void Controller::stop_not_finite(ControlSet& set) {
  supervisor_.raise(Fault::kNotFinite);
  change_mode(ControlMode::kOff);
  out_.current_A = 0.0F;
  force_.forget(set);
}

}  // namespace slipstack
