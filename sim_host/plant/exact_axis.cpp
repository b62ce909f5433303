// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/exact_axis.h"
#include "sim_host/gauss_legendre.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace slipstack::sim {
namespace {

template <typename Series>
double evaluate(const Series& series, double s) {
  double sum = 0.0;
  for (std::size_t n = series.size(); n-- > 0;) sum = sum * s + series[n];
  return sum;
}

template <typename Series>
double evaluate_slope(const Series& series, double s) {
  double sum = 0.0;
  for (std::size_t n = series.size(); n-- > 1;) sum = sum * s + static_cast<double>(n) * series[n];
  return sum;
}

// Root of series − level in [low, high], where it changes sign: Newton, bisection where Newton leaves the
// bracket.
template <typename Series>
double root(const Series& series, double level, double low, double high) {
  const bool rising = evaluate(series, high) > level;
  double s = 0.5 * (low + high);
  for (int i = 0; i < 80; ++i) {
    const double excess = evaluate(series, s) - level;
    if (excess == 0.0) return s;
    ((excess > 0.0) == rising ? high : low) = s;
    const double slope = evaluate_slope(series, s);
    double next = slope != 0.0 ? s - excess / slope : low;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::fabs(next - s) <= 1e-17 || next == s) return next;
    s = next;
  }
  return s;
}

template <typename Function>
double integrate(double to, Function function) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kGaussNodes.size(); ++i) {
    sum += kGaussWeights[i] *
           (function(0.5 * to * (1.0 - kGaussNodes[i])) + function(0.5 * to * (1.0 + kGaussNodes[i])));
  }
  return 0.5 * to * sum;
}

}  // namespace

ExactAxis::ExactAxis(const LinearPart& linear, MaxwellElements bank, double x_m)
    : linear_(linear), arm_kg_(linear.arm_ratio * linear.mass_kg), carriage_kg_(linear.mass_kg - arm_kg_) {
  if (!(linear.mass_kg > 0.0)) throw std::invalid_argument("exact axis: mass must be positive");
  if (!(linear.viscous_N_s_per_m >= 0.0 && linear.spring_N_per_m >= 0.0 && linear.arm_damping_ratio >= 0.0)) {
    throw std::invalid_argument("exact axis: damping and stiffness must not be negative");
  }
  if (!(linear.arm_ratio >= 0.0 && linear.arm_ratio < 1.0)) {
    throw std::invalid_argument("exact axis: the arm's share must be in [0, 1)");
  }
  bank.reset(x_m);
  restart(0.0, std::move(bank), 0.0);
}

void ExactAxis::restart(double t_s, MaxwellElements bank, double v_mps) {
  bank_ = std::move(bank);
  t_s_ = t_s;
  v_mps_ = v_mps;
  arm_m_ = arm_mps_ = 0.0;
  work_J_ = viscous_J_ = 0.0;
  reversals_ = events_ = 0;
  bank_start_J_ = bank_.dissipated_J();
  initial_J_ = mechanical_energy_J();
}

// Force on the carriage now, the arm's spring included, before viscous damping.
double ExactAxis::net_force_N() const {
  return force_.constant_N - bank_.force_N() -
         linear_.spring_N_per_m * (bank_.position_m() - linear_.spring_rest_m);
}

double ExactAxis::acceleration_mps2() const {
  return expand(1.0, 0.0).a[0];
}

double ExactAxis::longest_s(double stiffness, double left_s) const {
  double rate = std::sqrt((stiffness + linear_.spring_N_per_m) / carriage_kg_) +
                linear_.viscous_N_s_per_m / carriage_kg_;
  if (arm_kg_ > 0.0) {
    rate +=
        linear_.arm_rad_per_s / std::sqrt(1.0 - linear_.arm_ratio) * (1.0 + 2.0 * linear_.arm_damping_ratio);
  }
  if (force_.amplitude_N != 0.0) rate = std::max(rate, force_.rad_per_s);
  return rate * left_s > 1.0 ? 1.0 / rate : left_s;
}

// The power series of the motion from now, while nothing new slips:
//   m₁·a = F(t) − F_now − (K + k_s)·u − c·v + m₂·(ω²·q + 2ζω·q̇),   q̈ = −a − ω²·q − 2ζω·q̇.
ExactAxis::Stretch ExactAxis::expand(double length_s, double stiffness) const {
  Stretch out;
  out.length_s = length_s;
  out.v[0] = v_mps_;
  out.q[0] = arm_m_;
  out.w[0] = arm_mps_;
  const double h = length_s;
  const double k = stiffness + linear_.spring_N_per_m;
  const double c = linear_.viscous_N_s_per_m;
  const double arm_k = linear_.arm_rad_per_s * linear_.arm_rad_per_s;
  const double arm_c = 2.0 * linear_.arm_damping_ratio * linear_.arm_rad_per_s;
  const double angle = force_.rad_per_s * t_s_ + force_.phase_rad;
  const double cosine = std::cos(angle);
  const double sine = std::sin(angle);
  const std::array<double, 4> derivatives = {cosine, -sine, -cosine, sine};
  const double now_N = net_force_N();
  double sine_term = force_.amplitude_N;  // amplitude·(ωh)ⁿ/n!
  for (std::size_t n = 0; n < kTerms; ++n) {
    const double order = static_cast<double>(n + 1);
    const double pull = arm_k * out.q[n] + arm_c * out.w[n];
    const double force =
        (n == 0 ? now_N : 0.0) + sine_term * derivatives[n % 4] - k * out.u[n] - c * out.v[n];
    out.a[n] = (force + arm_kg_ * pull) / carriage_kg_;
    if (n + 1 < kTerms) {
      out.u[n + 1] = h * out.v[n] / order;
      out.v[n + 1] = h * out.a[n] / order;
      out.q[n + 1] = h * out.w[n] / order;
      out.w[n + 1] = h * (arm_kg_ > 0.0 ? -out.a[n] - pull : 0.0) / order;
    }
    sine_term *= force_.rad_per_s * h / order;
  }
  return out;
}

// The direction of the next motion: the sign of the velocity, or at standstill that of the first term of its
// series that is not zero.
int ExactAxis::coming_direction() const {
  if (v_mps_ != 0.0) return v_mps_ > 0.0 ? 1 : -1;
  const Stretch probe = expand(longest_s(bank_.initial_stiffness_N_per_m(), 1.0), 0.0);
  for (std::size_t n = 1; n < 6; ++n) {
    if (probe.v[n] != 0.0) return probe.v[n] > 0.0 ? 1 : -1;
  }
  return 0;
}

// The first s in (0, 1] at which the velocity changes sign; infinity when it does not.
double ExactAxis::first_reversal(const Stretch& stretch) const {
  const double direction = stretch.direction;
  const double v_end = direction * evaluate(stretch.v, 1.0);
  const double a_start = direction * stretch.a[0];
  const double a_end = direction * evaluate(stretch.a, 1.0);
  if (v_end < 0.0) {
    // From standstill the velocity first grows: the root lies after its maximum.
    const bool from_rest = stretch.v[0] == 0.0;
    const double low = from_rest && a_start * a_end < 0.0 ? root(stretch.a, 0.0, 0.0, 1.0) : 0.0;
    if (direction * evaluate(stretch.v, low) < 0.0) return low;
    return root(stretch.v, 0.0, low, 1.0);
  }
  if (a_start < 0.0 && a_end > 0.0) {
    // The speed falls and rises again: the velocity may have been below zero in between.
    const double slowest = root(stretch.a, 0.0, 0.0, 1.0);
    if (direction * evaluate(stretch.v, slowest) < 0.0) return root(stretch.v, 0.0, 0.0, slowest);
  }
  return std::numeric_limits<double>::infinity();
}

void ExactAxis::account(const Stretch& stretch, double s) {
  const double h = stretch.length_s;
  work_J_ += force_.constant_N * evaluate(stretch.u, s);
  if (force_.amplitude_N != 0.0) {
    work_J_ +=
        h * force_.amplitude_N * integrate(s, [&](double at) {
          return std::cos(force_.rad_per_s * (t_s_ + at * h) + force_.phase_rad) * evaluate(stretch.v, at);
        });
  }
  const double arm_c = 2.0 * linear_.arm_damping_ratio * linear_.arm_rad_per_s * arm_kg_;
  if (linear_.viscous_N_s_per_m > 0.0 || arm_c > 0.0) {
    viscous_J_ += h * integrate(s, [&](double at) {
                    const double v = evaluate(stretch.v, at);
                    const double w = evaluate(stretch.w, at);
                    return linear_.viscous_N_s_per_m * v * v + arm_c * w * w;
                  });
  }
}

void ExactAxis::commit(const Stretch& stretch, double s, Event event, double slip_at_m) {
  account(stretch, s);
  const double x_m = event == Event::kSlip ? slip_at_m : bank_.position_m() + evaluate(stretch.u, s);
  v_mps_ = event == Event::kReversal ? 0.0 : evaluate(stretch.v, s);
  arm_m_ = evaluate(stretch.q, s);
  arm_mps_ = evaluate(stretch.w, s);
  // An interval whose length rounds to zero must not reverse the friction.
  if (stretch.direction * (x_m - bank_.position_m()) > 0.0) bank_.move_to(x_m);
}

// Moves at most to t, ending at the first event.
ExactAxis::Event ExactAxis::stretch_to(double t_s) {
  const int direction = coming_direction();
  if (direction == 0) {
    t_s_ = t_s;
    return Event::kNone;
  }
  bank_.turn_to(direction);
  const double stiffness = bank_.sticking_stiffness();
  const double left_s = t_s - t_s_;
  Stretch stretch = expand(longest_s(stiffness, left_s), stiffness);
  stretch.direction = direction;

  double s = first_reversal(stretch);
  Event event = s <= 1.0 ? Event::kReversal : Event::kNone;
  s = std::min(s, 1.0);
  const double slip_at_m = bank_.next_slip_m(direction);
  const double to_slip_m = slip_at_m - bank_.position_m();
  if (direction * (evaluate(stretch.u, s) - to_slip_m) >= 0.0) {
    s = direction * to_slip_m > 0.0 ? root(stretch.u, to_slip_m, 0.0, s) : 0.0;
    event = Event::kSlip;
  }
  commit(stretch, s, event, slip_at_m);
  t_s_ = event == Event::kNone && stretch.length_s == left_s ? t_s : t_s_ + s * stretch.length_s;
  if (event != Event::kNone) ++events_;
  if (event == Event::kReversal) ++reversals_;
  return event;
}

void ExactAxis::advance_to(double t_s) {
  while (t_s_ < t_s) stretch_to(t_s);
}

bool ExactAxis::advance_to_reversal(double t_s) {
  while (t_s_ < t_s) {
    if (stretch_to(t_s) == Event::kReversal) return true;
  }
  return false;
}

double ExactAxis::mechanical_energy_J() const {
  const EnergyAudit audit = energy();
  return audit.kinetic + audit.stored;
}

EnergyAudit ExactAxis::energy() const {
  const double arm_v = v_mps_ + arm_mps_;
  const double spring_m = bank_.position_m() - linear_.spring_rest_m;
  EnergyAudit audit;
  audit.work = work_J_;
  audit.kinetic = 0.5 * (carriage_kg_ * v_mps_ * v_mps_ + arm_kg_ * arm_v * arm_v);
  audit.stored = bank_.stored_J() + 0.5 * linear_.spring_N_per_m * spring_m * spring_m +
                 0.5 * arm_kg_ * std::pow(linear_.arm_rad_per_s * arm_m_, 2);
  audit.dissipated = bank_.dissipated_J() - bank_start_J_ + viscous_J_;
  return audit;
}

}  // namespace slipstack::sim
