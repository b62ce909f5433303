// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/carriage.h"

#include <algorithm>
#include <stdexcept>

namespace slipstack::sim {
namespace {

void require(bool condition, const char* message) {
  if (!condition) throw std::invalid_argument(message);
}

void check(const Axis& axis) {
  require(axis.mass_kg > 0.0, "axis: mass must be positive");
  require(axis.elements > 0, "axis: at least one friction element");
  require(axis.stroke_m > 0.0, "axis: stroke must be positive");
  require(axis.motor_constant_N_per_A > 0.0, "axis: motor constant must be positive");
  require(axis.current_limit_A > 0.0, "axis: current limit must be positive");
  require(axis.encoder_resolution_m >= 0.0, "axis: negative encoder resolution");
  require(axis.force_noise_N >= 0.0, "axis: negative force noise");
  if (axis.effects.payload_kg) {
    require(axis.mass_kg + *axis.effects.payload_kg > 0.0, "axis: payload takes away more than the mass");
  }
  if (axis.effects.resonance) {
    const Resonance& arm = *axis.effects.resonance;
    require(arm.ratio > 0.0 && arm.ratio < 1.0, "resonance: ratio must be between 0 and 1");
    require(arm.frequency_rad_per_s > 0.0 && arm.damping_ratio >= 0.0,
            "resonance: frequency must be positive");
  }
  if (axis.effects.coulomb) {
    require(axis.effects.coulomb->level_N > 0.0 && axis.effects.coulomb->slip_m > 0.0,
            "coulomb: level and slip must be positive");
  }
  if (axis.outside.backlash) {
    const Backlash& backlash = *axis.outside.backlash;
    require(backlash.motor_share > 0.0 && backlash.motor_share < 1.0,
            "backlash: share must be between 0 and 1");
    require(backlash.gap_m >= 0.0 && backlash.contact_rad_per_s > 0.0, "backlash: gap must not be negative");
  }
}

}  // namespace

Carriage::Carriage(const Axis& axis) : axis_(axis), mass_kg_(axis.mass_kg) {
  check(axis);
  if (!axis.curve.terms().empty()) hysteresis_ = MaxwellElements::sample(axis.curve, axis.elements);
  if (axis.effects.coulomb) {
    const Coulomb& seal = *axis.effects.coulomb;
    coulomb_ = MaxwellElements({seal.level_N / seal.slip_m}, {seal.slip_m});
  }
  if (axis.outside.backlash) mass_kg_ *= 1.0 - axis.outside.backlash->motor_share;
}

Loads Carriage::loads_after(double t_s, double x_m, double v_mps, const InnerState& inner) const {
  return loads_on(axis_, mass_kg_, t_s, x_m, v_mps, hysteresis_.force_after_N(x_m),
                  coulomb_.force_after_N(x_m), inner);
}

void Carriage::carry(double payload_kg) {
  Axis loaded = axis_;
  loaded.effects.payload_kg = payload_kg;
  check(loaded);
  axis_ = loaded;
}

void Carriage::move_to(double x_m) {
  hysteresis_.move_to(x_m);
  coulomb_.move_to(x_m);
}

void Carriage::reset(double x_m) {
  hysteresis_.reset(x_m);
  coulomb_.reset(x_m);
}

double Carriage::largest_stiffness_N_per_m() const {
  return hysteresis_.initial_stiffness_N_per_m() + coulomb_.initial_stiffness_N_per_m();
}

double contact_force_N(const Backlash& backlash, double carriage_kg, double gap_m, double gap_mps) {
  const double w = backlash.contact_rad_per_s;
  const double stiffness = carriage_kg * w * w;
  const double damping = 2.0 * backlash.contact_damping_ratio * carriage_kg * w;
  const double half_m = 0.5 * backlash.gap_m;
  if (gap_m > half_m) return std::max(0.0, stiffness * (gap_m - half_m) + damping * gap_mps);
  if (gap_m < -half_m) return std::min(0.0, stiffness * (gap_m + half_m) + damping * gap_mps);
  return 0.0;
}

}  // namespace slipstack::sim
