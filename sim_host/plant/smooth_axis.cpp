// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/smooth_axis.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

namespace slipstack::sim {

bool has_mass_and_hysteresis_only(const Axis& axis) {
  const Effects& effects = axis.effects;
  return !(effects.coulomb || effects.viscous || effects.drag || effects.stribeck || effects.lag ||
           effects.preload || effects.acceleration || effects.asymmetry || effects.ripple ||
           effects.motor_ripple || effects.offset_N || effects.cable || effects.resonance || effects.drift ||
           axis.outside.line || axis.outside.bump || axis.current_loop_rad_per_s > 0.0);
}

SmoothAxis::SmoothAxis(const Axis& axis, double x_m) : SmoothAxis(axis, x_m, Options{}) {}

SmoothAxis::SmoothAxis(const Axis& axis, double x_m, const Options& options)
    : carriage_(axis),
      masing_(axis.curve, x_m),
      seal_(carriage_.coulomb()),
      options_(options),
      force_limit_N_(axis.current_limit_A * axis.motor_constant_N_per_A),
      plain_(has_mass_and_hysteresis_only(axis)),
      inner_(axis.effects.resonance || axis.effects.lag || axis.current_loop_rad_per_s > 0.0),
      mass_kg_(axis.mass_kg + axis.effects.payload_kg.value_or(0.0)) {
  if (axis.outside.backlash) throw std::invalid_argument("smooth axis: backlash is the tick-by-tick plant's");
  seal_.reset(x_m);
  y_[kX] = swing_start_m_ = x_ref_m_ = highest_m_ = lowest_m_ = x_m;
  y_[kLevel] = 1.0;
  fastest_rate_per_s_ = std::sqrt(
      std::min(masing_.initial_stiffness_N_per_m(), 1e3 * axis.curve.saturation_N() / axis.curve.travel_m()) /
      mass_kg_);
}

void SmoothAxis::place(double x_m) {
  if (x_m == y_[kX]) return;
  const double way_m = x_m - y_[kX];
  if (way_m * masing_.direction() < 0.0) masing_.turn(y_[kX]);
  while (masing_.direction() * (x_m - masing_.closing_m()) >= 0.0) masing_.close();
  seal_.move_to(x_m);
  y_ = {};
  y_[kX] = swing_start_m_ = x_ref_m_ = highest_m_ = lowest_m_ = x_m;
  y_[kLevel] = 1.0;
  x_scale_m_ = std::fabs(way_m);
  v_scale_mps_ = x_scale_m_ * fastest_rate_per_s_;
  rate_known_ = false;
}

void SmoothAxis::set_force(const SineForce& force) {
  force_ = force;
  force_start_s_ = t_s_;
  rate_known_ = false;
  // The size of the motion to come, until the first swing is known.
  const double size_N = std::fabs(force.constant_N) + std::fabs(force.amplitude_N);
  const double floor_m = 1e-3 * size_N / masing_.initial_stiffness_N_per_m();
  x_scale_m_ = std::max(x_scale_m_, floor_m);
  v_scale_mps_ = std::max(v_scale_mps_, floor_m * fastest_rate_per_s_);
  next_h_s_ = 0.05 / std::max(fastest_rate_per_s_, std::fabs(force.rad_per_s));
  highest_m_ = lowest_m_ = y_[kX];
  clear_integrals();
}

void SmoothAxis::clear_integrals() {
  y_[kCos] = y_[kSin] = y_[kMean] = 0.0;
  x_ref_m_ = y_[kX];
  rate_known_ = false;
}

void SmoothAxis::commit(const Step& step, double h_s, Event event) {
  y_ = step.end;
  rate_ = step.rate;
  t_s_ += h_s;
  if (carriage_.axis().effects.coulomb) seal_.move_to(y_[kX]);
  highest_m_ = std::max(highest_m_, y_[kX]);
  lowest_m_ = std::min(lowest_m_, y_[kX]);
  swing_v_mps_ = std::max(swing_v_mps_, std::fabs(y_[kV]));
  if (event == Event::kReversal) {
    y_[kV] = 0.0;
    rate_[kX] = 0.0;
    masing_.turn(y_[kX]);
    ++reversals_;
    // The size of the motion: the last swing, with a slow decay of larger ones before it.
    x_scale_m_ = std::max(std::fabs(y_[kX] - swing_start_m_), 0.5 * x_scale_m_);
    v_scale_mps_ = std::max(swing_v_mps_, 0.5 * v_scale_mps_);
    swing_start_m_ = y_[kX];
    swing_v_mps_ = 0.0;
  } else if (event == Event::kClosure) {
    masing_.close();
  }
}

// From standstill the branch of the friction must be that of the motion that follows.
void SmoothAxis::start_moving() {
  if (y_[kV] != 0.0) {
    if (y_[kV] * masing_.direction() < 0.0) masing_.turn(y_[kX]);
    return;
  }
  double a = rate_[kV];
  if (a == 0.0) {
    // The forces are balanced: the direction in which the force changes decides.
    a = -force_.amplitude_N * force_.rad_per_s *
        std::sin(force_.rad_per_s * (t_s_ - force_start_s_) + force_.phase_rad);
  }
  if (a * masing_.direction() < 0.0) masing_.turn(y_[kX]);
}

SmoothAxis::Event SmoothAxis::advance_once(double t_s) {
  if (!rate_known_) find_rate();
  start_moving();
  const double left_s = t_s - t_s_;
  const bool fixed = options_.fixed_step_s > 0.0;
  double h = fixed ? options_.fixed_step_s : next_h_s_;
  const bool last = h >= left_s * (1.0 - 1e-9);
  if (last) h = left_s;
  Step step = this->step(h);
  while (!fixed && step.error > 1.0 && h > 1e-14 * (1.0 + t_s_)) {
    h *= std::max(0.2, 0.9 * std::pow(step.error, -0.2));
    step = this->step(h);
  }
  const bool reached = last && h == left_s;
  if (!fixed && !(reached && left_s < next_h_s_)) {
    next_h_s_ = h * std::clamp(0.9 * std::pow(std::max(step.error, 1e-6), -0.2), 0.3, 4.0);
  }
  Event event = event_in(step, h);
  if (event == Event::kNone) {
    commit(step, h, event);
    if (reached) t_s_ = t_s;
    return event;
  }
  // A reversal may hide a closure shortly before it, and a closure a reversal: the shortened step shows the
  // other one.
  for (int i = 0; i < 3; ++i) {
    h = locate(event, step, h);
    const double direction = masing_.direction();
    const Event other = event == Event::kReversal ? Event::kClosure : Event::kReversal;
    const bool earlier = event == Event::kReversal
                             ? direction * (step.end[kX] - masing_.closing_m()) > 1e-12 * x_scale_m_
                             : direction * step.end[kV] < -1e-12 * v_scale_mps_;
    if (!earlier) break;
    event = other;
  }
  commit(step, h, event);
  return event;
}

void SmoothAxis::advance_to(double t_s) {
  while (t_s_ < t_s) advance_once(t_s);
}

bool SmoothAxis::advance_to_reversal(double t_s) {
  while (t_s_ < t_s) {
    if (advance_once(t_s) == Event::kReversal) return true;
  }
  return false;
}

std::vector<double> SmoothAxis::snapshot() const {
  std::vector<double> values(y_.begin(), y_.end());
  for (const double value :
       {t_s_, next_h_s_, x_scale_m_, v_scale_mps_, swing_start_m_, swing_v_mps_, x_ref_m_, highest_m_,
        lowest_m_, force_start_s_, static_cast<double>(reversals_)}) {
    values.push_back(value);
  }
  const std::vector<double> hysteresis = masing_.snapshot();
  const std::vector<double> seal = seal_.snapshot();
  values.insert(values.end(), seal.begin(), seal.end());
  values.insert(values.end(), hysteresis.begin(), hysteresis.end());
  return values;
}

void SmoothAxis::restore(const std::vector<double>& values) {
  constexpr std::size_t kOwn = kStates + 11;
  const std::size_t seal = seal_.snapshot().size();
  if (values.size() < kOwn + seal + 2) throw std::invalid_argument("smooth axis: not a snapshot");
  std::copy_n(values.begin(), kStates, y_.begin());
  const double* own = values.data() + kStates;
  for (double* target : {&t_s_, &next_h_s_, &x_scale_m_, &v_scale_mps_, &swing_start_m_, &swing_v_mps_,
                         &x_ref_m_, &highest_m_, &lowest_m_, &force_start_s_}) {
    *target = *own++;
  }
  reversals_ = static_cast<std::size_t>(*own);
  seal_.restore(std::span(values).subspan(kOwn, seal));
  masing_.restore(values.data() + kOwn + seal, values.size() - kOwn - seal);
  rate_known_ = false;
}

}  // namespace slipstack::sim
