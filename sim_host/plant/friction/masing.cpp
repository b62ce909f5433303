// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/friction/masing.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace slipstack::sim {

Masing::Masing(VirginCurve curve, double x_m) : curve_(std::move(curve)) {
  if (curve_.terms().empty()) throw std::invalid_argument("hysteresis: no virgin curve");
  const double travel_m = curve_.travel_m();
  // Rounding may move the body slightly beyond a reversal; there the branch is continued by its tangent.
  const double hair_m = 1e-9 * travel_m;
  stiffness_ = curve_.force_N(hair_m) / hair_m;
  tiny_m_ = 1e-12 * travel_m;
  reset(x_m);
}

void Masing::reset(double x_m) {
  reversals_.clear();
  origin_m_ = x_m;
  direction_ = 1;
  enter_branch();
}

// The branch that starts at the last reversal, or the virgin curve.
void Masing::enter_branch() {
  if (reversals_.empty()) {
    start_m_ = origin_m_;
    start_N_ = 0.0;
    scale_ = 1.0;
    closing_m_ = direction_ * std::numeric_limits<double>::infinity();
    return;
  }
  const Reversal& last = reversals_.back();
  start_m_ = last.x_m;
  start_N_ = last.force_N;
  scale_ = 2.0;
  // The first reversal lies on the virgin curve and its branch meets that curve's other half at the mirrored
  // place.
  closing_m_ = reversals_.size() > 1 ? reversals_[reversals_.size() - 2].x_m : 2.0 * origin_m_ - last.x_m;
}

void Masing::turn(double x_m) {
  // A half-swing that ends where its loop closes also closes the loop; otherwise every period of a periodic
  // motion would add reversals to the memory.
  while (std::fabs(x_m - closing_m_) <= tiny_m_) close();
  if (reversals_.empty() && std::fabs(x_m - origin_m_) <= tiny_m_) {
    direction_ = -direction_;
    enter_branch();
    return;
  }
  reversals_.push_back({x_m, force_N(x_m)});
  direction_ = -direction_;
  enter_branch();
  // Two reversals at one place cancel each other.
  while (!reversals_.empty() && std::fabs(x_m - closing_m_) <= tiny_m_) close();
}

void Masing::close() {
  if (reversals_.size() <= 1) {
    reversals_.clear();
  } else {
    reversals_.resize(reversals_.size() - 2);
  }
  enter_branch();
}

std::vector<double> Masing::snapshot() const {
  std::vector<double> values = {origin_m_, static_cast<double>(direction_)};
  for (const Reversal& reversal : reversals_) {
    values.push_back(reversal.x_m);
    values.push_back(reversal.force_N);
  }
  return values;
}

void Masing::restore(const double* values, std::size_t count) {
  if (count < 2 || count % 2 != 0) throw std::invalid_argument("hysteresis: not a snapshot");
  origin_m_ = values[0];
  direction_ = values[1] > 0.0 ? 1 : -1;
  reversals_.clear();
  for (std::size_t i = 2; i < count; i += 2) reversals_.push_back({values[i], values[i + 1]});
  enter_branch();
}

}  // namespace slipstack::sim
