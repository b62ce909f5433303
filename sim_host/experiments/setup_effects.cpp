// SPDX-License-Identifier: Apache-2.0
// The effects of the catalogue in a set-up file, and the virgin curve.
#include <algorithm>
#include <array>

#include "sim_host/experiments/setup_table.h"
#include "sim_host/plant/effects/effect_id.h"
#include "sim_host/turn.h"

namespace slipstack::sim {
namespace {

CurveTerm read_term(SetupTable& table) {
  CurveTerm term;
  constexpr std::array kKinds = {CurveKind::kExponential, CurveKind::kRational, CurveKind::kStretched,
                                 CurveKind::kPoints};
  term.kind = kKinds[table.word("kind", {"exponential", "rational", "stretched", "points"})];
  if (term.kind == CurveKind::kPoints) {
    term.points_m = table.numbers("displacement_m", kPositive);
    term.points_N = table.numbers("force_N", kPositive);
    if (term.points_m.size() != term.points_N.size()) {
      table.fail("displacement_m and force_N differ in length; give one force for each displacement",
                 "force_N");
    }
    term.level_N = term.points_N.back();
    term.length_m = term.points_m.back();
  } else {
    term.level_N = table.number("level_N", kPositive);
    term.length_m = table.number("length_m", kPositive);
  }
  if (term.kind == CurveKind::kStretched) term.exponent = table.number("exponent", kPositive);
  table.finish();
  return term;
}

WeakeningCurve read_weakening(SetupTable& table) {
  constexpr std::array kKinds = {WeakeningKind::kGaussian, WeakeningKind::kTustin, WeakeningKind::kLorentzian,
                                 WeakeningKind::kBoPavelescu, WeakeningKind::kHyperbolic};
  WeakeningCurve curve;
  curve.kind = kKinds[table.word("kind", {"gaussian", "tustin", "lorentzian", "bo_pavelescu", "hyperbolic"})];
  curve.depth = table.number("depth", {0.0, 1.0});
  curve.velocity_mps = table.number("velocity_mps", kPositive);
  curve.exponent = table.number_or("exponent", kPositive, 1.0);
  return curve;
}

FrictionalLag read_lag(SetupTable& table) {
  constexpr std::array kKinds = {LagKind::kTime, LagKind::kDistance, LagKind::kAttraction};
  FrictionalLag lag;
  lag.kind = kKinds[table.word("lag", {"time", "distance", "attraction"})];
  lag.curve = read_weakening(table);
  if (lag.kind == LagKind::kTime) lag.time_s = table.number("time_s", kPositive);
  if (lag.kind == LagKind::kDistance) lag.distance_m = table.number("distance_m", kPositive);
  if (lag.kind == LagKind::kAttraction) lag.attraction_per_s = table.number("attraction_per_s", kPositive);
  return lag;
}

PositionMap read_map(SetupTable& table, double stroke_m) {
  constexpr std::array kKinds = {MapKind::kSines, MapKind::kSpline, MapKind::kPiecewiseLinear, MapKind::kBump,
                                 MapKind::kTrend};
  switch (kKinds[table.word("kind", {"sines", "spline", "piecewise_linear", "bump", "trend"})]) {
    case MapKind::kSines: {
      const auto amplitude = table.numbers("amplitude", kAny);
      const auto length_m = table.numbers("length_m", kPositive);
      const auto phase_rad = table.numbers("phase_rad", kAny);
      if (amplitude.size() != length_m.size() || amplitude.size() != phase_rad.size()) {
        table.fail("amplitude, length_m and phase_rad differ in length; give as many of each", "phase_rad");
      }
      std::vector<PositionMap::Sine> sines;
      for (std::size_t i = 0; i < amplitude.size(); ++i) {
        sines.push_back({amplitude[i], length_m[i], phase_rad[i]});
      }
      return PositionMap::sines(stroke_m, std::move(sines));
    }
    case MapKind::kSpline:
    case MapKind::kPiecewiseLinear: {
      auto knots = table.numbers("knots", kAny);
      if (knots.size() < 3) table.fail("has fewer than 3 knots; give more", "knots");
      return table.text("kind") == "spline" ? PositionMap::spline(stroke_m, std::move(knots))
                                            : PositionMap::piecewise_linear(stroke_m, std::move(knots));
    }
    case MapKind::kBump: {
      const double centre_m = table.number("centre_m", {0.0, stroke_m});
      return PositionMap::bump(stroke_m, centre_m, table.number("width_m", kPositive));
    }
    case MapKind::kTrend:
      break;
  }
  return PositionMap::trend(stroke_m);
}

// Amplitudes of the harmonics 1, 2, 3 of the magnet pitch, in the unit of `amplitude_key`.
Ripple read_ripple(SetupTable& table, std::string_view amplitude_key, double pitch_m, const Range& range) {
  Ripple ripple;
  ripple.pitch_m = table.number_or("pitch_m", kPositive, pitch_m);
  const auto amplitude = table.numbers(amplitude_key, range);
  const auto phase_rad = table.numbers_or("phase_rad", kAny, std::vector<double>(amplitude.size(), 0.0));
  if (amplitude.size() != phase_rad.size()) {
    table.fail(fmt::format("{} and phase_rad differ in length; give as many of each", amplitude_key),
               "phase_rad");
  }
  for (std::size_t i = 0; i < amplitude.size(); ++i) {
    ripple.harmonics.push_back({static_cast<int>(i) + 1, amplitude[i], phase_rad[i]});
  }
  return ripple;
}

Drift read_drift(SetupTable& table) {
  constexpr std::array kKinds = {DriftKind::kWarming, DriftKind::kLinear, DriftKind::kRunIn,
                                 DriftKind::kCreep};
  constexpr std::array kTargets = {DriftTarget::kHysteresis, DriftTarget::kViscous, DriftTarget::kBoth};
  Drift drift;
  drift.kind = kKinds[table.word("kind", {"warming", "linear", "run_in", "creep"})];
  drift.target = kTargets[table.word("target", {"hysteresis", "viscous", "both"})];
  drift.depth = table.number("depth", {-1.0, 10.0});
  drift.time_s = table.number("time_s", kPositive);
  return drift;
}

void read_velocity_effects(SetupTable& file, Effects& effects) {
  if (auto table = file.table(name(EffectId::kViscous))) {
    effects.viscous = Viscous{table->number("coefficient_N_s_per_m", kNotNegative),
                              table->number_or("exponent", {0.1, 2.0}, 1.0)};
    table->finish();
  }
  if (auto table = file.table(name(EffectId::kQuadraticDrag))) {
    effects.drag = QuadraticDrag{table->number("coefficient", kNotNegative),
                                 table->number_or("exponent", {1.0, 3.0}, 2.0)};
    table->finish();
  }
  if (auto table = file.table(name(EffectId::kStribeck))) {
    effects.stribeck = read_weakening(*table);
    table->finish();
  }
  if (auto table = file.table(name(EffectId::kFrictionalLag))) {
    effects.lag = read_lag(*table);
    table->finish();
  }
  if (auto table = file.table(name(EffectId::kDirectionAsymmetry))) {
    constexpr std::array kLaws = {AsymmetryLaw::kByForce, AsymmetryLaw::kByVelocity};
    DirectionAsymmetry asymmetry;
    asymmetry.law = kLaws[table->word("law", {"by_force", "by_velocity"})];
    asymmetry.level = table->number("level", {-0.9, 0.9});
    asymmetry.viscous_N_s_per_m = table->number_or("viscous_N_s_per_m", kAny, 0.0);
    effects.asymmetry = asymmetry;
    table->finish();
  }
  if (auto table = file.table(name(EffectId::kAccelerationDependentPreload))) {
    constexpr std::array kLaws = {AccelerationLaw::kProportional, AccelerationLaw::kSmooth,
                                  AccelerationLaw::kSaturating};
    AccelerationPreload preload;
    preload.law = kLaws[table->word("law", {"proportional", "smooth", "saturating"})];
    preload.gain_s2_per_m = table->number("gain_s2_per_m", kAny);
    preload.knee_mps2 = table->number_or("knee_mps2", kPositive, 1.0);
    effects.acceleration = preload;
    table->finish();
  }
}

void read_position_effects(SetupTable& file, Axis& axis) {
  Effects& effects = axis.effects;
  if (auto table = file.table(name(EffectId::kCoulomb))) {
    effects.coulomb =
        Coulomb{table->number("level_N", kPositive), table->number_or("slip_m", kPositive, 20e-9)};
    table->finish();
  }
  if (auto table = file.table("preload_map")) {
    PositionPreload preload;
    preload.depth = table->number("depth", {-0.9, 0.9});
    preload.map = read_map(*table, axis.stroke_m);
    if (std::fabs(preload.depth) * preload.map.peak() >= 1.0) {
      table->fail("takes away more than the whole friction somewhere; lower depth", "depth");
    }
    effects.preload = preload;
    table->finish();
  }
  if (auto table = file.table("cogging")) {
    effects.ripple = read_ripple(*table, "amplitude_N", axis.magnet_pitch_m, kAny);
    table->finish();
  }
  if (auto table = file.table("force_constant_ripple")) {
    effects.motor_ripple = read_ripple(*table, "amplitude", axis.magnet_pitch_m, {-0.5, 0.5});
    table->finish();
  }
  if (auto table = file.table("cable_chain")) {
    CableChain cable;
    cable.stiffness_N_per_m = table->number("stiffness_N_per_m", kNotNegative);
    cable.rest_m = table->number_or("rest_m", kAny, 0.5 * axis.stroke_m);
    cable.stiffening = table->number_or("stiffening", kNotNegative, 0.0);
    cable.stroke_m = axis.stroke_m;
    effects.cable = cable;
    table->finish();
  }
}

}  // namespace

VirginCurve read_curve(SetupTable& file) {
  std::vector<CurveTerm> terms;
  for (SetupTable& table : file.tables("friction")) {
    terms.push_back(read_term(table));
    try {
      VirginCurve{{terms.back()}};
    } catch (const std::invalid_argument& error) {
      table.fail(fmt::format("{}; a virgin curve rises ever less steeply", error.what()));
    }
  }
  return VirginCurve(std::move(terms));
}

void read_effects(SetupTable& file, Axis& axis) {
  read_velocity_effects(file, axis.effects);
  read_position_effects(file, axis);
  if (file.has("offset_N")) axis.effects.offset_N = file.number("offset_N", kAny);
  if (file.has("added_mass_kg")) {
    axis.effects.payload_kg = file.number("added_mass_kg", {-0.99 * axis.mass_kg});
  }
  if (auto table = file.table("arm")) {
    Resonance arm;
    arm.ratio = table->number("mass_ratio", {0.0, 0.9, true});
    arm.frequency_rad_per_s = kTurn * table->number("frequency_Hz", kPositive);
    arm.damping_ratio = table->number("damping_ratio", {0.0, 1.0});
    axis.effects.resonance = arm;
    table->finish();
  }
  if (auto table = file.table(name(EffectId::kDrift))) {
    axis.effects.drift = read_drift(*table);
    table->finish();
  }
}

}  // namespace slipstack::sim
