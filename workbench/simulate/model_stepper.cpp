// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/model_stepper.h"

#include <algorithm>

#include "workbench/estimate/linear/linearisation.h"

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
  double plain = 0.0;
  double dry = 0.0;
  double dry_factor = 1.0;
  Forces forces;
  bool modulators = false;
  for (Part& part : parts_) {
    if (!part.dry && !modulators) {
      known.dry_friction_N = dry;
      modulators = true;
    }
    run(part, known);
    double dry_scale = 1.0;
    double total_scale = 1.0;
    for (std::size_t g = 0; g < part.gains.size(); ++g) {
      const double share = part.gains[g] * part.values[g];
      switch (part.acts[g]) {
        case Acts::force:
          plain += share;
          break;
        case Acts::dry:
          dry += share;
          break;
        case Acts::dry_scale:
          dry_scale += share;
          break;
        case Acts::total_scale:
          total_scale += share;
          break;
      }
    }
    dry_factor *= dry_scale;
    forces.factor *= total_scale;
  }
  forces.friction_N = dry * dry_factor + plain;
  return forces;
}

}  // namespace slipstack::workbench
