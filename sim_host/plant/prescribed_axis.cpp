// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/prescribed_axis.h"

#include <algorithm>
#include <cmath>

namespace slipstack::sim {

PrescribedAxis::PrescribedAxis(const Axis& axis, const MotionProgramme& programme, double start_s)
    : carriage_(axis), programme_(programme), t_s_(start_s), y_m_(programme.at(start_s).x_m) {
  carriage_.reset(y_m_);
}

bool PrescribedAxis::has_inner_dynamics() const {
  const Axis& axis = carriage_.axis();
  return axis.effects.resonance || axis.effects.lag || axis.outside.backlash;
}

double PrescribedAxis::fastest_rate_per_s() const {
  const Axis& axis = carriage_.axis();
  double rate = 0.0;
  if (axis.effects.resonance) rate = std::max(rate, axis.effects.resonance->frequency_rad_per_s);
  if (axis.effects.lag) {
    const double v = programme_.at(t_s_).v_mps;
    rate = std::max(rate, axis.effects.lag->relaxation(v).rate_per_s);
  }
  if (axis.outside.backlash) {
    rate = std::max(rate, axis.outside.backlash->contact_rad_per_s);
    rate = std::max(rate, std::sqrt(carriage_.largest_stiffness_N_per_m() / carriage_.mass_kg()));
  }
  return rate;
}

PrescribedAxis::State PrescribedAxis::rates(double t_s, const State& state) const {
  const Axis& axis = carriage_.axis();
  const MotionPoint motor = programme_.at(t_s);
  State out{};
  double v = motor.v_mps;
  double a = motor.a_mps2;
  if (axis.outside.backlash) {
    Loads loads = carriage_.loads_after(t_s, state.y_m, state.y_mps, state.inner);
    loads.motor_gain = 1.0;
    const double contact_N = contact_force_N(*axis.outside.backlash, carriage_.mass_kg(),
                                             motor.x_m - state.y_m, motor.v_mps - state.y_mps);
    v = state.y_mps;
    a = acceleration_mps2(axis, loads, contact_N);
    out.y_m = v;
    out.y_mps = a;
  }
  const InnerRates inner = inner_rates(axis, v, a, state.inner);
  out.inner = {inner.arm_mps, inner.arm_mps2, inner.level_per_s};
  return out;
}

void PrescribedAxis::integrate(double step_s) {
  const State start{y_m_, y_mps_, inner_};
  const auto moved = [&start](const State& rate, double h) {
    return State{start.y_m + h * rate.y_m,
                 start.y_mps + h * rate.y_mps,
                 {start.inner.arm_m + h * rate.inner.arm_m, start.inner.arm_mps + h * rate.inner.arm_mps,
                  start.inner.level + h * rate.inner.level}};
  };
  const State k1 = rates(t_s_, start);
  const State k2 = rates(t_s_ + 0.5 * step_s, moved(k1, 0.5 * step_s));
  const State k3 = rates(t_s_ + 0.5 * step_s, moved(k2, 0.5 * step_s));
  const State k4 = rates(t_s_ + step_s, moved(k3, step_s));
  const auto mean = [](double a, double b, double c, double d) { return (a + 2.0 * b + 2.0 * c + d) / 6.0; };
  y_m_ += step_s * mean(k1.y_m, k2.y_m, k3.y_m, k4.y_m);
  y_mps_ += step_s * mean(k1.y_mps, k2.y_mps, k3.y_mps, k4.y_mps);
  inner_.arm_m += step_s * mean(k1.inner.arm_m, k2.inner.arm_m, k3.inner.arm_m, k4.inner.arm_m);
  inner_.arm_mps += step_s * mean(k1.inner.arm_mps, k2.inner.arm_mps, k3.inner.arm_mps, k4.inner.arm_mps);
  inner_.level += step_s * mean(k1.inner.level, k2.inner.level, k3.inner.level, k4.inner.level);
  t_s_ += step_s;
  if (carriage_.axis().outside.backlash) carriage_.move_to(y_m_);
}

void PrescribedAxis::advance_to(double t_s) {
  const double start_s = t_s_;
  const bool rigid = !carriage_.axis().outside.backlash;
  if (rigid) {
    // Where the velocity changes sign in between, the friction reverses at the turning point.
    double low = t_s_;
    double high = t_s;
    const double v_low = programme_.at(low).v_mps;
    if (v_low * programme_.at(high).v_mps < 0.0) {
      for (int i = 0; i < 60 && high > low; ++i) {
        const double middle = 0.5 * (low + high);
        (programme_.at(middle).v_mps * v_low > 0.0 ? low : high) = middle;
      }
      carriage_.move_to(programme_.at(low).x_m);
    }
    carriage_.move_to(programme_.at(t_s).x_m);
  }
  if (has_inner_dynamics()) {
    constexpr double kStepTimesRate = 0.1;
    const double way_s = t_s - start_s;
    const int steps =
        std::clamp(static_cast<int>(std::ceil(way_s * fastest_rate_per_s() / kStepTimesRate)), 1, 200);
    for (int i = 0; i < steps; ++i) integrate(way_s / steps);
  }
  t_s_ = t_s;
}

PerEffect PrescribedAxis::parts() const {
  const Axis& axis = carriage_.axis();
  const MotionPoint motor = programme_.at(t_s_);
  PerEffect parts{};
  if (!axis.outside.backlash) {
    add_parts(axis, carriage_.loads_after(t_s_, motor.x_m, motor.v_mps, inner_), motor.a_mps2, parts);
    return parts;
  }
  Loads loads = carriage_.loads_after(t_s_, y_m_, y_mps_, inner_);
  const double gain = loads.motor_gain;
  loads.motor_gain = 1.0;
  const double contact_N =
      contact_force_N(*axis.outside.backlash, carriage_.mass_kg(), motor.x_m - y_m_, motor.v_mps - y_mps_);
  const double a = acceleration_mps2(axis, loads, contact_N);
  add_parts(axis, loads, a, parts);
  // Inertia as if all mass moved with the encoder; the difference belongs to the backlash.
  parts[index(EffectId::kInertia)] = axis.mass_kg * motor.a_mps2;
  parts[index(EffectId::kOutside)] += carriage_.mass_kg() * (a - motor.a_mps2);
  const double needed_N = contact_N + carriage_.motor_mass_kg() * motor.a_mps2;
  parts[index(EffectId::kMotorConstantRipple)] += needed_N / gain - needed_N;
  return parts;
}

}  // namespace slipstack::sim
