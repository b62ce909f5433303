// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/smooth_axis.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

namespace slipstack::sim {
namespace {

// Dormand-Prince 5(4): nodes, stages, weights are the seventh stage, error weights.
constexpr double kC2 = 1.0 / 5.0, kC3 = 3.0 / 10.0, kC4 = 4.0 / 5.0, kC5 = 8.0 / 9.0;
constexpr double kA21 = 1.0 / 5.0;
constexpr double kA31 = 3.0 / 40.0, kA32 = 9.0 / 40.0;
constexpr double kA41 = 44.0 / 45.0, kA42 = -56.0 / 15.0, kA43 = 32.0 / 9.0;
constexpr double kA51 = 19372.0 / 6561.0, kA52 = -25360.0 / 2187.0, kA53 = 64448.0 / 6561.0,
                 kA54 = -212.0 / 729.0;
constexpr double kA61 = 9017.0 / 3168.0, kA62 = -355.0 / 33.0, kA63 = 46732.0 / 5247.0, kA64 = 49.0 / 176.0,
                 kA65 = -5103.0 / 18656.0;
constexpr double kB1 = 35.0 / 384.0, kB3 = 500.0 / 1113.0, kB4 = 125.0 / 192.0, kB5 = -2187.0 / 6784.0,
                 kB6 = 11.0 / 84.0;
constexpr double kE1 = 71.0 / 57600.0, kE3 = -71.0 / 16695.0, kE4 = 71.0 / 1920.0, kE5 = -17253.0 / 339200.0,
                 kE6 = 22.0 / 525.0, kE7 = -1.0 / 40.0;

// States of a plain motion come first.
constexpr std::size_t kPlainStates = 5;

double cubic_root(double v0, double a0, double v1, double a1) {
  // Hermite cubic of the velocity over the step (derivatives times its length): its root in (0, 1).
  double low = 0.0;
  double high = 1.0;
  const auto value = [&](double s) {
    const double u = 1.0 - s;
    return u * u * ((1.0 + 2.0 * s) * v0 + s * a0) + s * s * ((1.0 + 2.0 * u) * v1 - u * a1);
  };
  const bool rising = v1 > 0.0;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (low + high);
    ((value(middle) > 0.0) == rising ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

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

double SmoothAxis::acceleration(double t_s, const State& y, double& drive_N) const {
  const Axis& axis = carriage_.axis();
  double command_N = std::clamp(drive_N, -force_limit_N_, force_limit_N_);
  if (axis.current_loop_rad_per_s > 0.0) {
    drive_N = axis.current_loop_rad_per_s * (command_N - y[kDrive]);
    command_N = y[kDrive];
  } else {
    drive_N = 0.0;
  }
  const InnerState inner = {y[kArm], y[kArmSpeed], y[kLevel]};
  const Loads loads = loads_on(axis, axis.mass_kg, t_s, y[kX], y[kV], masing_.force_N(y[kX]),
                               axis.effects.coulomb ? seal_.force_after_N(y[kX]) : 0.0, inner);
  return acceleration_mps2(axis, loads, command_N);
}

template <std::size_t kCount>
void SmoothAxis::rates(double t_s, const State& y, State& out) const {
  const double angle = force_.rad_per_s * (t_s - force_start_s_);
  const double cosine = std::cos(angle);
  const double sine = std::sin(angle);
  double force_N =
      force_.constant_N +
      force_.amplitude_N * (force_.phase_rad == 0.0 ? cosine : std::cos(angle + force_.phase_rad));
  out[kX] = y[kV];
  const double from_m = y[kX] - x_ref_m_;
  out[kCos] = from_m * cosine;
  out[kSin] = from_m * sine;
  out[kMean] = from_m;
  if (plain_) {
    out[kV] = (std::clamp(force_N, -force_limit_N_, force_limit_N_) - masing_.force_N(y[kX])) / mass_kg_;
  } else {
    const double a = acceleration(t_s, y, force_N);
    out[kV] = a;
    if constexpr (kCount > kPlainStates) {
      const InnerRates inner = inner_rates(carriage_.axis(), y[kV], a, {y[kArm], y[kArmSpeed], y[kLevel]});
      out[kArm] = inner.arm_mps;
      out[kArmSpeed] = inner.arm_mps2;
      out[kLevel] = inner.level_per_s;
      out[kDrive] = force_N;
    }
  }
}

template <std::size_t kCount>
SmoothAxis::Step SmoothAxis::try_step(double h) const {
  ++steps_;
  const State& k1 = rate_;
  State k2{}, k3{}, k4{}, k5{}, k6{};
  State y = y_;
  const auto moved = [&](auto&& increment) {
    for (std::size_t i = 0; i < kCount; ++i) y[i] = y_[i] + h * increment(i);
  };
  moved([&](std::size_t i) { return kA21 * k1[i]; });
  rates<kCount>(t_s_ + kC2 * h, y, k2);
  moved([&](std::size_t i) { return kA31 * k1[i] + kA32 * k2[i]; });
  rates<kCount>(t_s_ + kC3 * h, y, k3);
  moved([&](std::size_t i) { return kA41 * k1[i] + kA42 * k2[i] + kA43 * k3[i]; });
  rates<kCount>(t_s_ + kC4 * h, y, k4);
  moved([&](std::size_t i) { return kA51 * k1[i] + kA52 * k2[i] + kA53 * k3[i] + kA54 * k4[i]; });
  rates<kCount>(t_s_ + kC5 * h, y, k5);
  moved([&](std::size_t i) {
    return kA61 * k1[i] + kA62 * k2[i] + kA63 * k3[i] + kA64 * k4[i] + kA65 * k5[i];
  });
  rates<kCount>(t_s_ + h, y, k6);
  moved([&](std::size_t i) { return kB1 * k1[i] + kB3 * k3[i] + kB4 * k4[i] + kB5 * k5[i] + kB6 * k6[i]; });
  Step out;
  out.end = y;
  out.rate = {};
  rates<kCount>(t_s_ + h, y, out.rate);
  const auto error = [&](std::size_t i, double scale) {
    const double e = kE1 * k1[i] + kE3 * k3[i] + kE4 * k4[i] + kE5 * k5[i] + kE6 * k6[i] + kE7 * out.rate[i];
    return std::fabs(h * e) / scale;
  };
  const double x_size = std::max(x_scale_m_, std::fabs(y[kX] - swing_start_m_));
  const double v_size = std::max(v_scale_mps_, std::fabs(y[kV]));
  out.error = std::max(error(kX, x_size), error(kV, v_size));
  if constexpr (kCount > kPlainStates) {
    out.error = std::max({out.error, error(kArm, x_size), error(kArmSpeed, v_size), error(kLevel, 1.0),
                          error(kDrive, 1.0 + std::fabs(force_.amplitude_N) + std::fabs(force_.constant_N))});
  }
  out.error /= options_.tolerance;
  return out;
}

SmoothAxis::Step SmoothAxis::step(double h_s) const {
  return inner_ ? try_step<kStates>(h_s) : try_step<kPlainStates>(h_s);
}

// The event within a step. If there are two, the caller finds the earlier one by checking the shortened step.
SmoothAxis::Event SmoothAxis::event_in(const Step& step, double h_s) const {
  const double direction = masing_.direction();
  if (direction * (step.end[kX] - masing_.closing_m()) > 0.0) return Event::kClosure;
  if (direction * step.end[kV] < 0.0) return Event::kReversal;
  // The speed falls and rises again: the middle of the Hermite cubic shows whether the velocity was below
  // zero in between.
  if (direction * rate_[kV] < 0.0 && direction * step.rate[kV] > 0.0) {
    const double middle = 0.5 * (y_[kV] + step.end[kV]) + 0.125 * h_s * (rate_[kV] - step.rate[kV]);
    if (direction * middle < 0.0) return Event::kReversal;
  }
  return Event::kNone;
}

// The length of the step that ends at the event; `step` becomes that step.
double SmoothAxis::locate(Event event, Step& step, double h_s) const {
  double high = h_s;
  double h = 0.0;
  if (event == Event::kReversal) {
    const bool dips = masing_.direction() * step.end[kV] >= 0.0;
    h = dips ? 0.5 * h_s : h_s * cubic_root(y_[kV], h_s * rate_[kV], step.end[kV], h_s * step.rate[kV]);
  } else {
    h = h_s * std::clamp((masing_.closing_m() - y_[kX]) / (step.end[kX] - y_[kX]), 0.0, 1.0);
  }
  double low = 0.0;
  for (int i = 0; i < 12; ++i) {
    step = this->step(h);
    const double miss = event == Event::kReversal ? step.end[kV] : step.end[kX] - masing_.closing_m();
    const double slope = event == Event::kReversal ? step.rate[kV] : step.end[kV];
    const double close = event == Event::kReversal ? 1e-13 * v_scale_mps_ : 1e-13 * x_scale_m_;
    if (std::fabs(miss) <= close || slope == 0.0) break;
    const bool passed =
        event == Event::kReversal ? masing_.direction() * miss < 0.0 : masing_.direction() * miss > 0.0;
    (passed ? high : low) = h;
    double next = h - miss / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (next == h) break;
    h = next;
  }
  return h;
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
  if (!rate_known_) {
    rate_ = {};
    if (inner_) {
      rates<kStates>(t_s_, y_, rate_);
    } else {
      rates<kPlainStates>(t_s_, y_, rate_);
    }
    rate_known_ = true;
  }
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
