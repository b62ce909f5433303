// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/quasi_static.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "sim_host/rng.h"

namespace slipstack::sim {

MaxwellElements elements_between(const VirginCurve& curve, double smallest_m, double largest_m,
                                 std::size_t count) {
  if (!(smallest_m > 0.0) || !(largest_m >= smallest_m) || count < 2) {
    throw std::invalid_argument("loops: amplitudes must be positive and rising");
  }
  return MaxwellElements::sample(curve, smallest_m / 30.0, 3.0 * largest_m, count);
}

void move_to_force(MaxwellElements& bank, double force_N) {
  const double missing = force_N - bank.force_N();
  if (missing == 0.0) return;
  const int direction = missing > 0.0 ? 1 : -1;
  // Between events the bank is a spring. In every round another element begins to slip, so the loop ends.
  for (std::size_t round = 0; round <= bank.size(); ++round) {
    const double stiffness = bank.stiffness_towards(direction);
    const double slip_m = bank.next_slip_m(direction);
    const double target_m = bank.position_m() + (force_N - bank.force_N()) / stiffness;
    if (direction * (target_m - slip_m) <= 0.0) {
      bank.move_to(target_m);
      return;
    }
    bank.move_to(slip_m);
  }
}

QuasiStaticRecord record_loops(const MaxwellElements& bank, const QuasiStaticTest& test) {
  if (!(test.frequency_Hz > 0.0) || !(test.sample_rate_Hz > 8.0 * test.frequency_Hz)) {
    throw std::invalid_argument("loops: the sample rate must be well above a positive frequency");
  }
  for (const double force_N : test.forces_N) {
    if (!(force_N > 0.0)) throw std::invalid_argument("loops: force amplitudes must be positive");
    if (force_N >= bank.saturation_N()) {
      throw std::invalid_argument(
          "loops: a force amplitude reaches the saturation of the friction, the axis would roll away; lower "
          "it");
    }
  }
  MaxwellElements guideway = bank;
  Rng noise(test.seed, "quasi-static");
  QuasiStaticRecord record;
  const double omega = 2.0 * std::numbers::pi * test.frequency_Hz;
  const auto per_cycle = static_cast<std::size_t>(std::lround(test.sample_rate_Hz / test.frequency_Hz));
  const std::size_t per_force = per_cycle * test.cycles;
  for (std::size_t f = 0; f < test.forces_N.size(); ++f) {
    for (std::size_t i = 0; i < per_force; ++i) {
      const double t =
          static_cast<double>(f * per_force + i + 1) / (static_cast<double>(per_cycle) * test.frequency_Hz);
      // Whole cycles at one amplitude, so every change falls on a zero of the sine.
      const double force_N = test.forces_N[f] * std::sin(omega * t);
      move_to_force(guideway, force_N);
      double x = guideway.position_m();
      if (test.encoder_resolution_m > 0.0) {
        x = std::round(x / test.encoder_resolution_m) * test.encoder_resolution_m;
      }
      record.time_s.push_back(t);
      record.position_m.push_back(x);
      record.force_N.push_back(force_N + test.force_noise_N * noise.normal());
    }
  }
  return record;
}

std::vector<double> forces_for(const VirginCurve& curve, double smallest_m, double largest_m,
                               std::size_t count) {
  if (!(smallest_m > 0.0) || !(largest_m > smallest_m) || count < 2) {
    throw std::invalid_argument("loops: amplitudes must be positive and rising");
  }
  std::vector<double> forces;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count - 1);
    forces.push_back(curve.force_N(smallest_m * std::pow(largest_m / smallest_m, share)));
  }
  return forces;
}

}  // namespace slipstack::sim
