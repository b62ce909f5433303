// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/plant.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace slipstack::sim {

Plant::Plant(const Axis& axis, double x_m) : Plant(axis, x_m, Options{}) {}

Plant::Plant(const Axis& axis, double x_m, const Options& options)
    : carriage_(axis),
      options_(options),
      friction_x_(axis.outside.backlash ? kY : kX),
      friction_v_(axis.outside.backlash ? kW : kV) {
  const double carriage_kg =
      carriage_.mass_kg() * (axis.effects.resonance ? 1.0 - axis.effects.resonance->ratio : 1.0);
  steady_rate_per_s_ = std::sqrt(carriage_.largest_stiffness_N_per_m() / carriage_kg);
  if (axis.effects.resonance) {
    // The arm oscillates faster with the carriage free than with the carriage held.
    const Resonance& arm = *axis.effects.resonance;
    steady_rate_per_s_ = std::max(steady_rate_per_s_, arm.frequency_rad_per_s / std::sqrt(1.0 - arm.ratio));
  }
  if (axis.outside.backlash) {
    const Backlash& backlash = *axis.outside.backlash;
    steady_rate_per_s_ =
        std::max(steady_rate_per_s_, backlash.contact_rad_per_s / std::sqrt(backlash.motor_share));
  }
  steady_rate_per_s_ = std::max(steady_rate_per_s_, axis.current_loop_rad_per_s);
  reset(x_m);
}

void Plant::reset(double x_m, double v_mps) {
  state_ = {};
  state_[kX] = state_[kY] = x_m;
  state_[kV] = state_[kW] = v_mps;
  state_[kLevel] = 1.0;
  t_s_ = 0.0;
  steps_ = 0;
  carriage_.reset(x_m);
}

double Plant::command_N(double current_A) const {
  const Axis& axis = carriage_.axis();
  return std::clamp(current_A, -axis.current_limit_A, axis.current_limit_A) * axis.motor_constant_N_per_A;
}

double Plant::fastest_rate_per_s() const {
  const Axis& axis = carriage_.axis();
  if (!axis.effects.lag) return steady_rate_per_s_;
  return std::max(steady_rate_per_s_, axis.effects.lag->relaxation(state_[friction_v_]).rate_per_s);
}

Plant::State Plant::rates(double t_s, const State& state, double command_N, double disturbance_N) const {
  const Axis& axis = carriage_.axis();
  const double drive_N = (axis.current_loop_rad_per_s > 0.0 ? state[kDrive] : command_N) + disturbance_N;
  const InnerState inner = {state[kArm], state[kArmSpeed], state[kLevel]};
  Loads loads = carriage_.loads_after(t_s, state[friction_x_], state[friction_v_], inner);
  State out{};
  double a = 0.0;
  out[kX] = state[kV];
  if (axis.outside.backlash) {
    const double gain = loads.motor_gain;
    loads.motor_gain = 1.0;
    const double contact_N = contact_force_N(*axis.outside.backlash, carriage_.mass_kg(),
                                             state[kX] - state[kY], state[kV] - state[kW]);
    a = acceleration_mps2(axis, loads, contact_N);
    out[kV] = (gain * drive_N - contact_N) / carriage_.motor_mass_kg();
    out[kY] = state[kW];
    out[kW] = a;
  } else {
    a = acceleration_mps2(axis, loads, drive_N);
    out[kV] = a;
  }
  const InnerRates rate = inner_rates(axis, state[friction_v_], a, inner);
  out[kArm] = rate.arm_mps;
  out[kArmSpeed] = rate.arm_mps2;
  out[kLevel] = rate.level_per_s;
  out[kDrive] = axis.current_loop_rad_per_s * (command_N - state[kDrive]);
  return out;
}

Plant::State Plant::after(double h_s, double command_N, double disturbance_N) {
  ++steps_;
  const auto moved = [this](const State& rate, double h) {
    State out = state_;
    for (std::size_t i = 0; i < kStates; ++i) out[i] += h * rate[i];
    return out;
  };
  const State k1 = rates(t_s_, state_, command_N, disturbance_N);
  const State k2 = rates(t_s_ + 0.5 * h_s, moved(k1, 0.5 * h_s), command_N, disturbance_N);
  const State k3 = rates(t_s_ + 0.5 * h_s, moved(k2, 0.5 * h_s), command_N, disturbance_N);
  const State k4 = rates(t_s_ + h_s, moved(k3, h_s), command_N, disturbance_N);
  State out = state_;
  for (std::size_t i = 0; i < kStates; ++i) out[i] += h_s * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0;
  return out;
}

void Plant::commit(const State& state, double h_s) {
  state_ = state;
  t_s_ += h_s;
  carriage_.move_to(state_[friction_x_]);
}

// The step length at which a residual that changes sign within the step vanishes (Illinois rule).
template <typename Residual>
double Plant::locate(double h_s, double at_start, double at_end, double command_N, double disturbance_N,
                     Residual residual) {
  double low = 0.0;
  double high = h_s;
  double f_low = at_start;
  double f_high = at_end;
  int side = 0;
  for (int i = 0; i < 60 && high - low > 1e-15 * h_s; ++i) {
    const double h = std::clamp((f_low * high - f_high * low) / (f_low - f_high), low, high);
    const double f = residual(after(h, command_N, disturbance_N));
    if (f == 0.0 || h == low || h == high) return h;
    if ((f < 0.0) == (f_low < 0.0)) {
      low = h;
      f_low = f;
      if (side == -1) f_high *= 0.5;
      side = -1;
    } else {
      high = h;
      f_high = f;
      if (side == 1) f_low *= 0.5;
      side = 1;
    }
  }
  return high;
}

// One step of at most `longest_s`, ended early by an event; returns its length.
double Plant::substep(double longest_s, double command_N, double disturbance_N) {
  const double v_start = state_[friction_v_];
  const double x_start = state_[friction_x_];
  double h = longest_s;
  State end = after(h, command_N, disturbance_N);
  const bool turned = v_start * end[friction_v_] < 0.0;
  if (turned) {
    h = locate(h, v_start, end[friction_v_], command_N, disturbance_N,
               [this](const State& s) { return s[friction_v_]; });
    end = after(h, command_N, disturbance_N);
    end[friction_v_] = 0.0;
  }
  if (options_.locate_slips && end[friction_x_] != x_start) {
    const double ahead = carriage_.hysteresis().next_slip_m(end[friction_x_] > x_start ? 1 : -1);
    const double before = x_start - ahead;
    const double behind = end[friction_x_] - ahead;
    if (before * behind < 0.0) {
      h = locate(h, before, behind, command_N, disturbance_N,
                 [this, ahead](const State& s) { return s[friction_x_] - ahead; });
      end = after(h, command_N, disturbance_N);
      end[friction_x_] = ahead;
    }
  }
  commit(end, h);
  return h;
}

void Plant::step(double current_A, double dt_s, double disturbance_N) {
  if (!(dt_s > 0.0)) throw std::invalid_argument("plant: step must be positive");
  const double end_s = t_s_ + dt_s;
  const double command = command_N(current_A);
  const double steps = std::ceil(dt_s * fastest_rate_per_s() / options_.step_times_rate);
  const double longest_s = dt_s / std::max(1.0, steps);
  double left_s = dt_s;
  while (left_s > 1e-12 * dt_s) left_s -= substep(std::min(longest_s, left_s), command, disturbance_N);
  t_s_ = end_s;
}

PerEffect Plant::parts(double current_A, double disturbance_N) const {
  const Axis& axis = carriage_.axis();
  const State rate = rates(t_s_, state_, command_N(current_A), disturbance_N);
  const InnerState inner = {state_[kArm], state_[kArmSpeed], state_[kLevel]};
  Loads loads = carriage_.loads_after(t_s_, state_[friction_x_], state_[friction_v_], inner);
  PerEffect parts{};
  const double gain = loads.motor_gain;
  if (axis.outside.backlash) loads.motor_gain = 1.0;
  add_parts(axis, loads, rate[friction_v_], parts);
  if (axis.outside.backlash) {
    parts[index(EffectId::kInertia)] = axis.mass_kg * rate[kV];
    parts[index(EffectId::kOutside)] += carriage_.mass_kg() * (rate[kW] - rate[kV]);
    double needed_N = 0.0;
    for (const double part : parts) needed_N += part;
    parts[index(EffectId::kMotorConstantRipple)] += needed_N / gain - needed_N;
  }
  // The part of the command that the current loop has not yet followed acts later.
  if (axis.current_loop_rad_per_s > 0.0) {
    parts[index(EffectId::kTimeDelay)] += command_N(current_A) - state_[kDrive];
  }
  return parts;
}

}  // namespace slipstack::sim
