// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/friction/maxwell_elements.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace slipstack::sim {

MaxwellElements::MaxwellElements(std::vector<double> stiffness_N_per_m, std::vector<double> slip_m)
    : stiffness_(std::move(stiffness_N_per_m)), slip_(std::move(slip_m)) {
  if (stiffness_.size() != slip_.size()) throw std::invalid_argument("element bank: sizes differ");
  for (std::size_t i = 0; i < slip_.size(); ++i) {
    if (!(stiffness_[i] >= 0.0)) throw std::invalid_argument("element bank: negative stiffness");
    if (!(slip_[i] > (i == 0 ? 0.0 : slip_[i - 1]))) {
      throw std::invalid_argument("element bank: slip distances must be positive and increasing");
    }
  }
  const std::size_t count = slip_.size();
  tail_stiffness_.assign(count + 1, 0.0);
  slipping_force_.assign(count + 1, 0.0);
  for (std::size_t i = count; i-- > 0;) tail_stiffness_[i] = tail_stiffness_[i + 1] + stiffness_[i];
  for (std::size_t i = 0; i < count; ++i)
    slipping_force_[i + 1] = slipping_force_[i] + stiffness_[i] * slip_[i];
  reset(0.0);
}

MaxwellElements MaxwellElements::sample(const VirginCurve& curve, std::size_t count) {
  return sample(curve, 1e-3 * curve.travel_m(), curve.displacement_m(0.9999), count);
}

MaxwellElements MaxwellElements::sample(const VirginCurve& curve, double first_m, double last_m,
                                        std::size_t count) {
  std::vector<double> slip(count);
  std::vector<double> slope(count + 1, 0.0);
  double previous_m = 0.0;
  double previous_N = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 1.0;
    slip[i] = first_m * std::pow(last_m / first_m, share);
    const double force_N = curve.force_N(slip[i]);
    slope[i] = (force_N - previous_N) / (slip[i] - previous_m);
    previous_m = slip[i];
    previous_N = force_N;
  }
  std::vector<double> stiffness(count);
  for (std::size_t i = 0; i < count; ++i) stiffness[i] = std::max(0.0, slope[i] - slope[i + 1]);
  return MaxwellElements(std::move(stiffness), std::move(slip));
}

void MaxwellElements::reset(double x_m) {
  anchor_.assign(slip_.size(), x_m);
  x_m_ = event_x_m_ = x_m;
  direction_ = 0;
  slipping_ = 0;
  event_force_N_ = 0.0;
  dissipated_J_ = 0.0;
}

double MaxwellElements::anchor_m(std::size_t i) const {
  return i < slipping_ ? x_m_ - direction_ * slip_[i] : anchor_[i];
}

double MaxwellElements::elongation_m(std::size_t i) const {
  return i < slipping_ ? direction_ * slip_[i] : x_m_ - anchor_[i];
}

void MaxwellElements::turn_to(int direction) {
  if (direction == direction_) return;
  // The force is summed anew at every reversal, so that rounding errors do not accumulate over many events.
  double force = 0.0;
  for (std::size_t i = 0; i < slip_.size(); ++i) {
    force += stiffness_[i] * elongation_m(i);
    anchor_[i] = anchor_m(i);
  }
  slipping_ = 0;
  direction_ = direction;
  event_x_m_ = x_m_;
  event_force_N_ = force;
}

void MaxwellElements::move_to(double x_m) {
  if (x_m == x_m_) return;
  turn_to(x_m > x_m_ ? 1 : -1);
  while (slipping_ < slip_.size()) {
    const double slip_at = anchor_[slipping_] + direction_ * slip_[slipping_];
    if (direction_ * (x_m - slip_at) < 0.0) break;
    // Rounding can put the event slightly behind the body; the body never moves back.
    const double at = direction_ * (slip_at - x_m_) > 0.0 ? slip_at : x_m_;
    event_force_N_ += sticking_stiffness() * (at - event_x_m_);
    dissipated_J_ += slipping_force_[slipping_] * std::fabs(at - x_m_);
    event_x_m_ = x_m_ = at;
    ++slipping_;
  }
  dissipated_J_ += slipping_force_[slipping_] * std::fabs(x_m - x_m_);
  x_m_ = x_m;
}

double MaxwellElements::force_after_N(double x_m) const {
  if (x_m == x_m_) return force_N();
  const int direction = x_m > x_m_ ? 1 : -1;
  double force = force_N();
  double at = x_m_;
  std::size_t slipping = direction == direction_ ? slipping_ : 0;
  for (; slipping < slip_.size(); ++slipping) {
    const double slip_at = anchor_m(slipping) + direction * slip_[slipping];
    if (direction * (x_m - slip_at) < 0.0) break;
    if (direction * (slip_at - at) > 0.0) {
      force += tail_stiffness_[slipping] * (slip_at - at);
      at = slip_at;
    }
  }
  return force + tail_stiffness_[slipping] * (x_m - at);
}

double MaxwellElements::stiffness_towards(int direction) const {
  return direction == direction_ ? sticking_stiffness() : initial_stiffness_N_per_m();
}

double MaxwellElements::next_slip_m(int direction) const {
  const std::size_t next = direction == direction_ ? slipping_ : 0;
  if (next >= slip_.size()) return direction * std::numeric_limits<double>::infinity();
  return anchor_m(next) + direction * slip_[next];
}

std::vector<double> MaxwellElements::snapshot() const {
  std::vector<double> values = {x_m_,
                                static_cast<double>(direction_),
                                static_cast<double>(slipping_),
                                event_x_m_,
                                event_force_N_,
                                dissipated_J_};
  values.insert(values.end(), anchor_.begin(), anchor_.end());
  return values;
}

void MaxwellElements::restore(std::span<const double> values) {
  constexpr std::size_t kOwn = 6;
  if (values.size() != kOwn + slip_.size()) throw std::invalid_argument("element bank: not a snapshot");
  x_m_ = values[0];
  direction_ = static_cast<int>(values[1]);
  slipping_ = std::min(static_cast<std::size_t>(values[2]), slip_.size());
  event_x_m_ = values[3];
  event_force_N_ = values[4];
  dissipated_J_ = values[5];
  std::copy(values.begin() + kOwn, values.end(), anchor_.begin());
}

double MaxwellElements::stored_J() const {
  double energy = 0.0;
  for (std::size_t i = 0; i < slip_.size(); ++i) {
    const double z = elongation_m(i);
    energy += 0.5 * stiffness_[i] * z * z;
  }
  return energy;
}

}  // namespace slipstack::sim
