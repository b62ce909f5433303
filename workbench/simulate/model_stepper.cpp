// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/model_stepper.h"

#include <algorithm>

#include "workbench/estimate/linear/linearisation.h"
#include "workbench/model/composition.h"

namespace slipstack::workbench {

ModelStepper::ModelStepper(const Terms& terms, double tick_s)
    : mass_kg_(workbench::mass_kg(terms)), lag_(measurement_dynamics_of(terms)) {
  for (const Term& term : terms) {
    if (term.gains.empty() || is_mass(term)) continue;
    Part part;
    part.basis = term.effect->make();
    part.basis->prepare(term.shapes, {.tick_s = tick_s, .metres_per_displacement = 1.0});
    part.gains = term.gains;
    for (std::size_t g = 0; g < term.gains.size(); ++g) {
      part.acts.push_back(term.effect->group_of_gain(static_cast<int>(g)).acts);
    }
    part.values.resize(term.gains.size());
    part.dry = term.effect->acts_as(Acts::dry);
    if (term.effect->has_role(Role::hysteresis)) {
      for (const double stiffness : term.gains) stiffness_N_per_m_ += stiffness;
    }
    parts_.push_back(std::move(part));
  }
  // Dry friction first: the others may modulate it.
  std::stable_partition(parts_.begin(), parts_.end(), [](const Part& part) { return part.dry; });
}

void ModelStepper::reset(const Sample<double>& sample) {
  for (Part& part : parts_) part.basis->reset(sample);
}

void ModelStepper::run(Part& part, const Sample<double>& sample) {
  part.basis->run(std::span(&sample, 1), part.values.data());
}

ModelStepper::Forces ModelStepper::step(const Sample<double>& sample) {
  Sample<double> known = sample;
  double plain_N = 0.0;
  double dry_N = 0.0;
  double dry_factor = 1.0;
  Forces forces;
  bool dry_is_complete = false;
  for (Part& part : parts_) {
    if (!part.dry && !dry_is_complete) {
      known.dry_friction_N = dry_N;
      dry_is_complete = true;
    }
    run(part, known);
    double dry_scale = 1.0;
    double total_scale = 1.0;
    for (std::size_t g = 0; g < part.gains.size(); ++g) {
      by_acts(part.acts[g], plain_N, dry_N, dry_scale, total_scale) += part.gains[g] * part.values[g];
    }
    dry_factor *= dry_scale;
    forces.factor *= total_scale;
  }
  forces.friction_N = composed_friction_N(plain_N, dry_N, dry_factor);
  return forces;
}

}  // namespace slipstack::workbench
