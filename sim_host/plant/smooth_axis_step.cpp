// SPDX-License-Identifier: Apache-2.0
// One step of the smooth axis: Runge-Kutta stages, error estimate, and the event at which the step ends.
#include <algorithm>
#include <cmath>

#include "sim_host/plant/smooth_axis.h"

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

void SmoothAxis::find_rate() {
  rate_ = {};
  if (inner_) {
    rates<kStates>(t_s_, y_, rate_);
  } else {
    rates<kPlainStates>(t_s_, y_, rate_);
  }
  rate_known_ = true;
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

}  // namespace slipstack::sim
