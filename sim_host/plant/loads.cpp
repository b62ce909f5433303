// SPDX-License-Identifier: Apache-2.0
#include "sim_host/plant/loads.h"

#include <cmath>
#include <numbers>

namespace slipstack::sim {
namespace {

void load_friction(const Axis& axis, double t_s, double x_m, double v_mps, const InnerState& inner,
                   Loads& out) {
  const Effects& effects = axis.effects;
  if (effects.stribeck) out.stribeck = effects.stribeck->level(v_mps);
  if (effects.lag) out.lag = inner.level;
  if (effects.preload) out.preload = effects.preload->factor(x_m);
  if (effects.viscous) out.viscous_N = effects.viscous->force_N(v_mps);
  if (effects.asymmetry) {
    out.asymmetry = effects.asymmetry->factor(out.hysteresis_N, axis.curve.saturation_N(), v_mps);
    out.viscous_asymmetry_N = effects.asymmetry->viscous_N_s_per_m * std::fabs(v_mps);
  }
  if (effects.drift) {
    const double factor = effects.drift->factor(t_s);
    if (effects.drift->target != DriftTarget::kViscous) out.drift = factor;
    if (effects.drift->target != DriftTarget::kHysteresis) {
      out.viscous_drift_N = (factor - 1.0) * (out.viscous_N + out.viscous_asymmetry_N);
    }
  }
  if (effects.drag) out.drag_N = effects.drag->force_N(v_mps);
}

void load_position(const Axis& axis, double t_s, double x_m, Loads& out) {
  const Effects& effects = axis.effects;
  if (effects.ripple) out.ripple_N = effects.ripple->value(x_m);
  if (effects.motor_ripple) out.motor_gain = 1.0 + effects.motor_ripple->value(x_m);
  if (effects.offset_N) out.offset_N = *effects.offset_N;
  if (effects.cable) out.cable_N = effects.cable->force_N(x_m);
  if (axis.outside.bump) {
    const BumpForce& bump = *axis.outside.bump;
    const double u = (x_m - bump.centre_m) / bump.width_m;
    out.outside_N += bump.amplitude_N * std::exp(-0.5 * u * u);
  }
  if (axis.outside.line) {
    const LineForce& line = *axis.outside.line;
    out.outside_N +=
        line.amplitude_N * std::sin(2.0 * std::numbers::pi * line.frequency_Hz * t_s + line.phase_rad);
  }
}

}  // namespace

Loads loads_on(const Axis& axis, double mass_kg, double t_s, double x_m, double v_mps, double hysteresis_N,
               double coulomb_N, const InnerState& inner) {
  Loads out;
  out.mass_kg = mass_kg;
  out.hysteresis_N = hysteresis_N;
  out.coulomb_N = coulomb_N;
  load_friction(axis, t_s, x_m, v_mps, inner, out);
  load_position(axis, t_s, x_m, out);
  if (axis.effects.payload_kg) out.payload_kg = *axis.effects.payload_kg;
  if (axis.effects.resonance) {
    const Resonance& arm = *axis.effects.resonance;
    const double w = arm.frequency_rad_per_s;
    out.arm_kg = arm.ratio * mass_kg;
    out.arm_N = -out.arm_kg * (w * w * inner.arm_m + 2.0 * arm.damping_ratio * w * inner.arm_mps);
  }
  return out;
}

double drive_force_N(const Axis& axis, const Loads& loads, double a_mps2) {
  const double preload = axis.effects.acceleration ? axis.effects.acceleration->factor(a_mps2) : 1.0;
  const double inertia_kg = loads.mass_kg - loads.arm_kg + loads.payload_kg;
  return (inertia_kg * a_mps2 + preload * loads.modulated_N() + loads.rest_N()) / loads.motor_gain;
}

double acceleration_mps2(const Axis& axis, const Loads& loads, double drive_force_N) {
  const double inertia_kg = loads.mass_kg - loads.arm_kg + loads.payload_kg;
  const double friction_N = loads.modulated_N();
  const double net_N = drive_force_N * loads.motor_gain - friction_N - loads.rest_N();
  double a = net_N / inertia_kg;
  if (!axis.effects.acceleration) return a;
  const AccelerationPreload& law = *axis.effects.acceleration;
  if (law.law == AccelerationLaw::kProportional) {
    return net_N / (inertia_kg + std::copysign(law.gain_s2_per_m, net_N) * friction_N);
  }
  for (int i = 0; i < 30; ++i) {
    const double step = 1e-6 * (1.0 + std::fabs(a));
    const double slope = (law.shape(a + step) - law.shape(a - step)) / (2.0 * step);
    const double excess_N = inertia_kg * a + friction_N * law.gain_s2_per_m * law.shape(a) - net_N;
    const double change = excess_N / (inertia_kg + friction_N * law.gain_s2_per_m * slope);
    a -= change;
    if (std::fabs(change) <= 1e-14 * (1.0 + std::fabs(a))) break;
  }
  return a;
}

void add_parts(const Axis& axis, const Loads& loads, double a_mps2, PerEffect& parts) {
  const auto add = [&parts](EffectId id, double force_N) { parts[index(id)] += force_N; };
  add(EffectId::kInertia, loads.mass_kg * a_mps2);
  add(EffectId::kPayloadMass, loads.payload_kg * a_mps2);
  add(EffectId::kStructuralResonance, loads.arm_N - loads.arm_kg * a_mps2);
  add(EffectId::kPreslidingHysteresis, loads.hysteresis_N);
  double product_N = loads.hysteresis_N;
  const auto modulate = [&](EffectId id, double factor) {
    add(id, product_N * (factor - 1.0));
    product_N *= factor;
  };
  modulate(EffectId::kStribeck, loads.stribeck);
  modulate(EffectId::kFrictionalLag, loads.lag);
  modulate(EffectId::kPositionDependentPreload, loads.preload);
  modulate(EffectId::kDirectionAsymmetry, loads.asymmetry);
  modulate(EffectId::kDrift, loads.drift);
  if (axis.effects.acceleration) {
    modulate(EffectId::kAccelerationDependentPreload, axis.effects.acceleration->factor(a_mps2));
  }
  add(EffectId::kCoulomb, loads.coulomb_N);
  add(EffectId::kViscous, loads.viscous_N);
  add(EffectId::kDirectionAsymmetry, loads.viscous_asymmetry_N);
  add(EffectId::kDrift, loads.viscous_drift_N);
  add(EffectId::kQuadraticDrag, loads.drag_N);
  add(EffectId::kForceRipple, loads.ripple_N);
  add(EffectId::kOffsetForce, loads.offset_N);
  add(EffectId::kCableChainStiffness, loads.cable_N);
  add(EffectId::kOutside, loads.outside_N);
  const double drive_N = drive_force_N(axis, loads, a_mps2);
  add(EffectId::kMotorConstantRipple, drive_N * (1.0 - loads.motor_gain));
}

InnerRates inner_rates(const Axis& axis, double v_mps, double a_mps2, const InnerState& inner) {
  InnerRates rates;
  if (axis.effects.resonance) {
    const Resonance& arm = *axis.effects.resonance;
    const double w = arm.frequency_rad_per_s;
    rates.arm_mps = inner.arm_mps;
    rates.arm_mps2 = -a_mps2 - w * w * inner.arm_m - 2.0 * arm.damping_ratio * w * inner.arm_mps;
  }
  if (axis.effects.lag) {
    const auto [rate, target] = axis.effects.lag->relaxation(v_mps);
    rates.level_per_s = rate * (target - inner.level);
  }
  return rates;
}

}  // namespace slipstack::sim
