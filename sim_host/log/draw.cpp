// SPDX-License-Identifier: Apache-2.0
#include "sim_host/log/draw.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipstack::sim {
namespace {

CurveTerm draw_term(Rng& rng, double level_N, double travel_m) {
  CurveTerm term;
  term.kind = rng.pick({CurveKind::kExponential, CurveKind::kRational, CurveKind::kStretched});
  term.level_N = level_N;
  if (term.kind == CurveKind::kStretched) term.exponent = rng.uniform(0.6, 0.95);
  // Length 1 first, then to the travel wanted.
  term.length_m = 1.0;
  term.length_m = travel_m / VirginCurve({term}).travel_m();
  return term;
}

VirginCurve draw_curve(Rng& rng, double level_N, double travel_m) {
  if (rng.chance(0.7)) return VirginCurve({draw_term(rng, level_N, travel_m)});
  const double share = rng.uniform(0.4, 0.7);
  const double ratio = rng.uniform(4.0, 12.0);
  std::vector<CurveTerm> terms = {draw_term(rng, share * level_N, travel_m / ratio),
                                  draw_term(rng, (1.0 - share) * level_N, travel_m)};
  const double stretch = travel_m / VirginCurve(terms).travel_m();
  for (CurveTerm& term : terms) term.length_m *= stretch;
  return VirginCurve(std::move(terms));
}

// Encoders come in steps of 1, 2, 5. The finest ones go with the shortest travels.
double draw_resolution(Rng& rng, double travel_m) {
  std::vector<double> fitting;
  for (const double step_m : {10e-9, 20e-9, 50e-9, 100e-9, 200e-9, 500e-9, 1e-6}) {
    if (step_m < travel_m / 20.0 && step_m > travel_m / 400.0) fitting.push_back(step_m);
  }
  return fitting.empty() ? 10e-9 : rng.pick(fitting);
}

Bench draw_pick_and_place(Rng& rng) {
  Bench bench;
  Axis& axis = bench.axis;
  axis.mass_kg = 35.45;
  std::vector<CurveTerm> rails(2);
  rails[0] = {CurveKind::kExponential, 8.0, rng.uniform(5.5e-6, 7.5e-6), 1.0};
  rails[1] = {CurveKind::kRational, 7.0, rng.uniform(6e-6, 9e-6), 1.0};
  axis.curve = VirginCurve(std::move(rails));
  axis.stroke_m = 0.4;
  axis.magnet_pitch_m = 0.024;
  axis.motor_constant_N_per_A = 60.0;
  axis.current_limit_A = 10.0;
  axis.encoder_resolution_m = 1e-6;
  axis.force_noise_N = rng.uniform(0.12, 0.3);
  bench.programme = {60.0, 5e-6, 40e-6};
  return bench;
}

Bench draw_random(Rng& rng) {
  Bench bench;
  Axis& axis = bench.axis;
  axis.mass_kg = rng.log_uniform(1.0, 60.0);
  const double level_N = rng.log_uniform(std::max(1.0, 0.12 * axis.mass_kg), 30.0);
  // Rolling guideways oscillate below some 600 Hz on their pre-sliding stiffness, so a light axis is not
  // stiff.
  const double stiffest_m = 2.0 * level_N / (axis.mass_kg * std::pow(2.0 * std::numbers::pi * 600.0, 2));
  const double travel_m = std::max(rng.log_uniform(1e-6, 50e-6), stiffest_m);
  axis.curve = draw_curve(rng, level_N, travel_m);
  axis.magnet_pitch_m = rng.log_uniform(0.010, 0.060);
  axis.stroke_m = std::max(rng.log_uniform(0.08, 0.5), 3.0 * axis.magnet_pitch_m);
  axis.motor_constant_N_per_A = rng.log_uniform(15.0, 120.0);
  axis.current_limit_A = (12.0 * axis.mass_kg + 4.0 * level_N) / axis.motor_constant_N_per_A;
  axis.encoder_resolution_m = draw_resolution(rng, travel_m);
  axis.force_noise_N = level_N * rng.log_uniform(0.005, 0.03);
  bench.programme.seconds = rng.uniform(40.0, 80.0);
  bench.rate_Hz = rng.pick({1000.0, 2000.0, 2000.0, 2500.0, 4000.0, 5000.0});
  return bench;
}

}  // namespace

Bench draw_bench(Setup setup, std::uint64_t seed) {
  Rng rng(seed, "axis");
  return setup == Setup::kPickAndPlace ? draw_pick_and_place(rng) : draw_random(rng);
}

MotionProgramme draw_programme(const Bench& bench, std::uint64_t seed) {
  Rng motion(seed, "motion");
  return make_test_programme(bench.axis, bench.programme, motion);
}

const std::vector<EffectId>& drawable_effects() {
  static const std::vector<EffectId> kList = {
      EffectId::kViscous,
      EffectId::kQuadraticDrag,
      EffectId::kStribeck,
      EffectId::kFrictionalLag,
      EffectId::kPositionDependentPreload,
      EffectId::kAccelerationDependentPreload,
      EffectId::kDirectionAsymmetry,
      EffectId::kForceRipple,
      EffectId::kMotorConstantRipple,
      EffectId::kOffsetForce,
      EffectId::kCableChainStiffness,
      EffectId::kPayloadMass,
      EffectId::kStructuralResonance,
      EffectId::kTimeDelay,
      EffectId::kDrift,
  };
  return kList;
}

std::vector<EffectId> draw_effect_ids(std::size_t count, std::uint64_t seed) {
  Rng rng(seed, "which effect");
  std::vector<EffectId> chosen;
  const auto taken = [&chosen](EffectId id) {
    return std::find(chosen.begin(), chosen.end(), id) != chosen.end();
  };
  while (chosen.size() < std::min(count, drawable_effects().size() - 1)) {
    const EffectId id = rng.pick(drawable_effects());
    const bool twin = (id == EffectId::kStribeck && taken(EffectId::kFrictionalLag)) ||
                      (id == EffectId::kFrictionalLag && taken(EffectId::kStribeck));
    if (!taken(id) && !twin) chosen.push_back(id);
  }
  return chosen;
}

double noise_floor_N(const Axis& axis) {
  // A rounding error of q/√12 through the mean stiffness of the first half of the travel, in the third of the
  // record that is pre-sliding.
  const double stiffness = axis.curve.force_N(0.5 * axis.curve.travel_m()) / (0.5 * axis.curve.travel_m());
  const double steps_N = axis.encoder_resolution_m / std::sqrt(12.0) * stiffness * std::sqrt(1.0 / 3.0);
  return std::hypot(axis.force_noise_N, steps_N);
}

}  // namespace slipstack::sim
