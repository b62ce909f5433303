// SPDX-License-Identifier: Apache-2.0
// How each effect is drawn: formula and shape at random, gain by its contribution to the force.
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/turn.h"

namespace slipstack::sim {
namespace {

// An effect of which all but the gain is drawn.
struct Sketch {
  std::function<void(Axis&, double)> set_gain;
  double largest_gain;
};

WeakeningCurve draw_weakening(Rng& rng) {
  WeakeningCurve curve;
  curve.kind = rng.pick({WeakeningKind::kGaussian, WeakeningKind::kTustin, WeakeningKind::kLorentzian,
                         WeakeningKind::kBoPavelescu, WeakeningKind::kHyperbolic});
  curve.velocity_mps = rng.log_uniform(4e-3, 40e-3);
  if (curve.kind == WeakeningKind::kBoPavelescu) curve.exponent = rng.uniform(0.5, 2.0);
  return curve;
}

FrictionalLag draw_lag(Rng& rng) {
  FrictionalLag lag;
  lag.kind = rng.pick({LagKind::kTime, LagKind::kDistance, LagKind::kAttraction});
  lag.curve = draw_weakening(rng);
  lag.time_s = rng.log_uniform(0.03, 0.3);
  lag.distance_m = rng.log_uniform(0.4e-3, 4e-3);
  lag.attraction_per_s = 1.0 / rng.log_uniform(0.03, 0.3);
  return lag;
}

PositionMap draw_map(Rng& rng, double stroke_m) {
  const auto knots = [&rng] {
    std::vector<double> values(4 + rng.below(5));
    for (double& value : values) value = rng.uniform(-1.0, 1.0);
    return values;
  };
  switch (rng.pick(
      {MapKind::kSpline, MapKind::kSines, MapKind::kPiecewiseLinear, MapKind::kBump, MapKind::kTrend})) {
    case MapKind::kSpline:
      return PositionMap::spline(stroke_m, knots());
    case MapKind::kPiecewiseLinear:
      return PositionMap::piecewise_linear(stroke_m, knots());
    case MapKind::kSines: {
      std::vector<PositionMap::Sine> sines(1 + rng.below(3));
      for (auto& sine : sines) {
        sine = {rng.uniform(0.3, 1.0), stroke_m / rng.uniform(0.6, 3.0), rng.uniform(0.0, kTurn)};
      }
      return PositionMap::sines(stroke_m, std::move(sines));
    }
    case MapKind::kBump:
      return PositionMap::bump(stroke_m, stroke_m * rng.uniform(0.2, 0.8), stroke_m * rng.uniform(0.06, 0.2));
    case MapKind::kTrend:
      break;
  }
  return PositionMap::trend(stroke_m);
}

// Relative amplitudes with root mean square 1/√2 of the largest; one to three of the orders 1, 2, 3.
Ripple draw_ripple(Rng& rng, double pitch_m) {
  Ripple ripple;
  ripple.pitch_m = pitch_m;
  const std::size_t count = 1 + rng.below(3);
  const int first = rng.chance(0.8) ? 1 : 2;
  for (std::size_t i = 0; i < count; ++i) {
    const double amplitude = i == 0 ? 1.0 : rng.uniform(0.2, 0.8);
    ripple.harmonics.push_back({first + static_cast<int>(i), amplitude, rng.uniform(0.0, kTurn)});
  }
  return ripple;
}

Ripple scaled(Ripple ripple, double gain) {
  for (auto& harmonic : ripple.harmonics) harmonic.amplitude *= gain;
  return ripple;
}

// Friction that depends on velocity, and related effects.
Sketch sketch_friction(EffectId id, const Axis& axis, double duration_s, Rng& rng) {
  const double level_N = axis.curve.saturation_N();
  switch (id) {
    case EffectId::kCoulomb: {
      // Slip distance such that the seal's own frequency stays below 400 Hz at the largest gain.
      const double largest_N = 0.6 * level_N;
      const double slip_m = std::max(20e-9, largest_N / (axis.mass_kg * std::pow(kTurn * 400.0, 2)));
      return {[slip_m](Axis& a, double gain) { a.effects.coulomb = Coulomb{gain, slip_m}; }, largest_N};
    }
    case EffectId::kViscous: {
      const double exponent = rng.chance(0.6) ? 1.0 : rng.uniform(0.9, 1.05);
      return {[exponent](Axis& a, double gain) {
                a.effects.viscous = Viscous{gain, exponent};
              },
              4.0 * level_N};
    }
    case EffectId::kQuadraticDrag: {
      const double exponent = rng.chance(0.6) ? 2.0 : rng.uniform(1.8, 2.2);
      return {[exponent](Axis& a, double gain) {
                a.effects.drag = QuadraticDrag{gain, exponent};
              },
              12.0 * level_N};
    }
    case EffectId::kStribeck: {
      const WeakeningCurve curve = draw_weakening(rng);
      return {[curve](Axis& a, double gain) {
                a.effects.stribeck = curve;
                a.effects.stribeck->depth = gain;
              },
              0.55};
    }
    case EffectId::kFrictionalLag: {
      const FrictionalLag lag = draw_lag(rng);
      return {[lag](Axis& a, double gain) {
                a.effects.lag = lag;
                a.effects.lag->curve.depth = gain;
              },
              0.55};
    }
    case EffectId::kDirectionAsymmetry: {
      DirectionAsymmetry asymmetry;
      asymmetry.law = rng.pick({AsymmetryLaw::kByForce, AsymmetryLaw::kByVelocity});
      const double sign = rng.sign();
      // Where the axis has viscous friction, in half of the cases it differs by direction too, by at most its
      // own size.
      const double viscous =
          axis.effects.viscous && rng.chance(0.5)
              ? rng.sign() * rng.uniform(0.3, 1.0) * axis.effects.viscous->coefficient_N_s_per_m
              : 0.0;
      return {[asymmetry, sign, viscous](Axis& a, double gain) {
                a.effects.asymmetry = asymmetry;
                a.effects.asymmetry->level = sign * gain;
                a.effects.asymmetry->viscous_N_s_per_m = viscous * std::min(1.0, gain / 0.35);
              },
              0.35};
    }
    default: {
      Drift drift;
      drift.kind = rng.pick({DriftKind::kWarming, DriftKind::kLinear, DriftKind::kRunIn, DriftKind::kCreep});
      drift.time_s = duration_s * (drift.kind == DriftKind::kLinear ? 1.0 : rng.log_uniform(0.15, 1.0));
      if (axis.effects.viscous) {
        drift.target = rng.pick({DriftTarget::kHysteresis, DriftTarget::kViscous, DriftTarget::kBoth});
      }
      const double sign = drift.kind == DriftKind::kRunIn ? 1.0 : rng.sign();
      Drift unit = drift;
      unit.depth = 1.0;
      const double change = std::fabs(unit.factor(duration_s) - 1.0);
      return {[drift, sign](Axis& a, double gain) {
                a.effects.drift = drift;
                a.effects.drift->depth = sign * gain;
              },
              0.5 / change};
    }
  }
}

// Effects of position or acceleration, and additional forces and masses.
Sketch sketch_other(EffectId id, const Axis& axis, double rate_Hz, Rng& rng) {
  const double level_N = axis.curve.saturation_N();
  switch (id) {
    case EffectId::kPositionDependentPreload: {
      const PositionMap map = draw_map(rng, axis.stroke_m);
      const double sign = rng.sign();
      return {[map, sign](Axis& a, double gain) {
                a.effects.preload = PositionPreload{map, sign * gain};
              },
              0.6 / map.peak()};
    }
    case EffectId::kAccelerationDependentPreload: {
      AccelerationPreload law;
      law.law =
          rng.pick({AccelerationLaw::kProportional, AccelerationLaw::kSmooth, AccelerationLaw::kSaturating});
      law.knee_mps2 = law.law == AccelerationLaw::kSmooth ? rng.uniform(0.3, 1.5) : rng.uniform(5.0, 15.0);
      return {[law](Axis& a, double gain) {
                a.effects.acceleration = law;
                a.effects.acceleration->gain_s2_per_m = gain;
              },
              0.15};
    }
    case EffectId::kForceRipple: {
      // In a quarter of the cases the ripple comes from the balls or a screw and has a pitch of its own.
      const double pitch_m =
          rng.chance(0.75) ? axis.magnet_pitch_m : rng.log_uniform(0.003, 0.25 * axis.stroke_m);
      const Ripple ripple = draw_ripple(rng, pitch_m);
      return {[ripple](Axis& a, double gain) { a.effects.ripple = scaled(ripple, gain); }, level_N};
    }
    case EffectId::kMotorConstantRipple: {
      const Ripple ripple = draw_ripple(rng, axis.magnet_pitch_m);
      return {[ripple](Axis& a, double gain) { a.effects.motor_ripple = scaled(ripple, gain); }, 0.06};
    }
    case EffectId::kOffsetForce: {
      const double sign = rng.sign();
      return {[sign](Axis& a, double gain) { a.effects.offset_N = sign * gain; }, 0.8 * level_N};
    }
    case EffectId::kCableChainStiffness: {
      CableChain cable;
      cable.rest_m = axis.stroke_m * rng.uniform(-0.2, 0.8);
      cable.stiffening = rng.chance(0.5) ? 0.0 : rng.uniform(0.1, 0.5);
      cable.stroke_m = axis.stroke_m;
      return {[cable](Axis& a, double gain) {
                a.effects.cable = cable;
                a.effects.cable->stiffness_N_per_m = gain;
              },
              1.5 * level_N / axis.stroke_m};
    }
    case EffectId::kPayloadMass:
      return {[](Axis& a, double gain) { a.effects.payload_kg = gain; }, 0.25 * axis.mass_kg};
    case EffectId::kStructuralResonance: {
      Resonance arm;
      arm.frequency_rad_per_s = kTurn * rng.log_uniform(10.0, std::min(60.0, rate_Hz / 20.0));
      arm.damping_ratio = rng.log_uniform(0.008, 0.06);
      return {[arm](Axis& a, double gain) {
                a.effects.resonance = arm;
                a.effects.resonance->ratio = gain;
              },
              0.3};
    }
    default: {
      // All delay, all filter, or some of each; the gain is their sum in seconds.
      const double share = rng.pick({0.0, 1.0, rng.uniform(0.2, 0.8)});
      return {[share](Axis& a, double gain) {
                a.effects.delay = RecordingDelay{share * gain, (1.0 - share) * gain};
              },
              std::max(2e-3, 4.0 / rate_Hz)};
    }
  }
}

Sketch sketch(EffectId id, const Axis& axis, double duration_s, double rate_Hz, Rng& rng) {
  switch (id) {
    case EffectId::kCoulomb:
    case EffectId::kViscous:
    case EffectId::kQuadraticDrag:
    case EffectId::kStribeck:
    case EffectId::kFrictionalLag:
    case EffectId::kDirectionAsymmetry:
    case EffectId::kDrift:
      return sketch_friction(id, axis, duration_s, rng);
    case EffectId::kInertia:
    case EffectId::kPreslidingHysteresis:
    case EffectId::kOutside:
    case EffectId::kCount:
      break;
    default:
      return sketch_other(id, axis, rate_Hz, rng);
  }
  throw std::invalid_argument(std::string(name(id)) + " is not an effect that can be hidden");
}

}  // namespace

void add_effects(Axis& axis, const std::vector<EffectId>& effects, const MotionProgramme& programme,
                 double rate_Hz, double strength, std::uint64_t seed) {
  std::vector<EffectId> ordered = effects;
  std::sort(ordered.begin(), ordered.end());  // viscous friction before the effects that scale it
  ordered.erase(std::unique(ordered.begin(), ordered.end()), ordered.end());
  double faintest_N = 1e300;
  double faintest_ratio = 1.5;
  for (const EffectId id : ordered) {
    // A stream per effect: adding one does not change the others.
    Rng rng(seed, std::string("effect ") + std::string(name(id)));
    const double ratio = strength > 0.0 ? strength : rng.log_uniform(1.5, 15.0);
    const Sketch effect = sketch(id, axis, programme.duration_s(), rate_Hz, rng);
    const double wanted_N = ratio * noise_floor_N(axis);
    const auto rms_N = [&](double gain) {
      Axis trial = axis;
      trial.force_noise_N = 0.0;
      effect.set_gain(trial, gain);
      return simulate_log(trial, programme, rate_Hz, seed).parts_rms_N[index(id)];
    };
    double gain = 0.25 * effect.largest_gain;
    double got_N = 0.0;
    for (int i = 0; i < 2; ++i) {
      got_N = rms_N(gain);
      gain = std::min(effect.largest_gain, gain * wanted_N / got_N);
    }
    effect.set_gain(axis, gain);
    got_N = rms_N(gain);
    if (got_N / std::min(ratio, 1.5) < faintest_N / faintest_ratio) {
      faintest_N = got_N;
      faintest_ratio = std::min(ratio, 1.5);
    }
  }
  if (!ordered.empty()) axis.force_noise_N = std::min(axis.force_noise_N, faintest_N / faintest_ratio);
}

}  // namespace slipstack::sim
