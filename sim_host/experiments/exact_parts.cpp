// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/exact_parts.h"

#include <fmt/format.h>

#include "sim_host/plant/effects/effect_id.h"

namespace slipstack::sim {
namespace {

// The first effect that has no closed form between events; empty when there is none.
std::string_view nonlinear_effect(const Effects& effects) {
  if (effects.coulomb) return name(EffectId::kCoulomb);
  if (effects.viscous && effects.viscous->exponent != 1.0) return "viscous with an exponent";
  if (effects.drag) return name(EffectId::kQuadraticDrag);
  if (effects.stribeck) return name(EffectId::kStribeck);
  if (effects.lag) return name(EffectId::kFrictionalLag);
  if (effects.preload) return "preload_map";
  if (effects.acceleration) return name(EffectId::kAccelerationDependentPreload);
  if (effects.asymmetry) return name(EffectId::kDirectionAsymmetry);
  if (effects.ripple) return "cogging";
  if (effects.motor_ripple) return "force_constant_ripple";
  if (effects.offset_N) return "offset_N";
  if (effects.cable && effects.cable->stiffening != 0.0) return "cable_chain that stiffens";
  if (effects.drift) return name(EffectId::kDrift);
  return {};
}

}  // namespace

LinearPart linear_part(const ExperimentSetup& setup, std::string_view experiment) {
  if (const std::string_view effect = nonlinear_effect(setup.axis.effects); !effect.empty()) {
    throw SetupError(fmt::format("{}: {} is event-exact and cannot have {}; take it out of the set-up",
                                 setup.name, experiment, effect));
  }
  const Effects& effects = setup.axis.effects;
  LinearPart linear;
  linear.mass_kg = setup.axis.mass_kg + effects.payload_kg.value_or(0.0);
  if (effects.viscous) linear.viscous_N_s_per_m = effects.viscous->coefficient_N_s_per_m;
  if (effects.cable) {
    linear.spring_N_per_m = effects.cable->stiffness_N_per_m;
    linear.spring_rest_m = effects.cable->rest_m - setup.position_m;
  }
  if (effects.resonance) {
    linear.arm_ratio = effects.resonance->ratio * setup.axis.mass_kg / linear.mass_kg;
    linear.arm_rad_per_s = effects.resonance->frequency_rad_per_s;
    linear.arm_damping_ratio = effects.resonance->damping_ratio;
  }
  return linear;
}

MaxwellElements maxwell_elements(const ExperimentSetup& setup) {
  return MaxwellElements::sample(setup.axis.curve, setup.axis.elements);
}

}  // namespace slipstack::sim
