// SPDX-License-Identifier: Apache-2.0
// The truth file: one block of formula and numbers per effect.
#include <nlohmann/json.hpp>

#include "sim_host/log/write.h"

namespace slipstack::sim {
namespace {

using Json = nlohmann::ordered_json;

Json describe(const VirginCurve& curve) {
  Json terms = Json::array();
  for (const CurveTerm& term : curve.terms()) {
    Json entry = {{"formula", name(term.kind)}, {"level_N", term.level_N}, {"length_m", term.length_m}};
    if (term.kind == CurveKind::kStretched) entry["exponent"] = term.exponent;
    terms.push_back(entry);
  }
  return terms;
}

Json describe(const WeakeningCurve& curve) {
  Json out = {{"depth", curve.depth}, {"velocity_mps", curve.velocity_mps}};
  if (curve.kind == WeakeningKind::kBoPavelescu) out["exponent"] = curve.exponent;
  return out;
}

Json describe(const Ripple& ripple) {
  Json harmonics = Json::array();
  for (const auto& harmonic : ripple.harmonics) {
    harmonics.push_back(
        {{"order", harmonic.order}, {"amplitude", harmonic.amplitude}, {"phase_rad", harmonic.phase_rad}});
  }
  return {{"pitch_m", ripple.pitch_m}, {"harmonics", harmonics}};
}

Json describe(const FrictionalLag& lag) {
  Json out = describe(lag.curve);
  switch (lag.kind) {
    case LagKind::kTime:
      out["time_s"] = lag.time_s;
      break;
    case LagKind::kDistance:
      out["distance_m"] = lag.distance_m;
      break;
    case LagKind::kAttraction:
      out["attraction_per_s"] = lag.attraction_per_s;
      break;
  }
  return out;
}

// Collects formula and parameters of every effect.
struct Sheet {
  Json formulas = Json::object();
  Json parameters = Json::object();
  void add(EffectId id, std::string_view formula, Json numbers) {
    formulas[std::string(name(id))] = formula;
    parameters[std::string(name(id))] = std::move(numbers);
  }
};

void describe_friction(const Effects& effects, Sheet& sheet) {
  if (effects.coulomb) {
    sheet.add(EffectId::kCoulomb, "one_maxwell_element",
              {{"level_N", effects.coulomb->level_N}, {"slip_m", effects.coulomb->slip_m}});
  }
  if (effects.viscous) {
    sheet.add(EffectId::kViscous, effects.viscous->exponent == 1.0 ? "linear" : "shear_thinning",
              {{"coefficient_N_s_per_m", effects.viscous->coefficient_N_s_per_m},
               {"exponent", effects.viscous->exponent}});
  }
  if (effects.drag) {
    sheet.add(EffectId::kQuadraticDrag, effects.drag->exponent == 2.0 ? "quadratic" : "power",
              {{"coefficient", effects.drag->coefficient}, {"exponent", effects.drag->exponent}});
  }
  if (effects.stribeck)
    sheet.add(EffectId::kStribeck, name(effects.stribeck->kind), describe(*effects.stribeck));
  if (effects.lag) {
    sheet.add(EffectId::kFrictionalLag,
              std::string(name(effects.lag->kind)) + " of " + std::string(name(effects.lag->curve.kind)),
              describe(*effects.lag));
  }
  if (effects.asymmetry) {
    sheet.add(
        EffectId::kDirectionAsymmetry, name(effects.asymmetry->law),
        {{"level", effects.asymmetry->level}, {"viscous_N_s_per_m", effects.asymmetry->viscous_N_s_per_m}});
  }
  if (effects.drift) {
    sheet.add(EffectId::kDrift,
              std::string(name(effects.drift->kind)) + " on " + std::string(name(effects.drift->target)),
              {{"depth", effects.drift->depth}, {"time_s", effects.drift->time_s}});
  }
}

void describe_others(const Effects& effects, Sheet& sheet) {
  if (effects.preload) {
    sheet.add(EffectId::kPositionDependentPreload, name(effects.preload->map.kind()),
              {{"depth", effects.preload->depth}, {"map", effects.preload->map.numbers()}});
  }
  if (effects.acceleration) {
    sheet.add(EffectId::kAccelerationDependentPreload, name(effects.acceleration->law),
              {{"gain_s2_per_m", effects.acceleration->gain_s2_per_m},
               {"knee_mps2", effects.acceleration->knee_mps2}});
  }
  if (effects.ripple) sheet.add(EffectId::kForceRipple, "harmonics", describe(*effects.ripple));
  if (effects.motor_ripple)
    sheet.add(EffectId::kMotorConstantRipple, "harmonics", describe(*effects.motor_ripple));
  if (effects.offset_N) sheet.add(EffectId::kOffsetForce, "constant", {{"force_N", *effects.offset_N}});
  if (effects.cable) {
    sheet.add(EffectId::kCableChainStiffness, effects.cable->stiffening == 0.0 ? "linear" : "stiffening",
              {{"stiffness_N_per_m", effects.cable->stiffness_N_per_m},
               {"rest_m", effects.cable->rest_m},
               {"stiffening", effects.cable->stiffening}});
  }
  if (effects.payload_kg) sheet.add(EffectId::kPayloadMass, "mass", {{"mass_kg", *effects.payload_kg}});
  if (effects.resonance) {
    sheet.add(EffectId::kStructuralResonance, "mass_on_spring",
              {{"ratio", effects.resonance->ratio},
               {"frequency_Hz", effects.resonance->frequency_rad_per_s / 6.283185307179586},
               {"damping_ratio", effects.resonance->damping_ratio}});
  }
  if (effects.delay) {
    const bool pure = effects.delay->filter_s == 0.0;
    const bool filter = effects.delay->delay_s == 0.0;
    sheet.add(EffectId::kTimeDelay, pure ? "delay" : (filter ? "first_order_filter" : "delay_and_filter"),
              {{"delay_s", effects.delay->delay_s}, {"filter_s", effects.delay->filter_s}});
  }
}

Json describe(const Outside& outside, const SimulatedLog& log, double noise_N) {
  Json out = Json::object();
  if (outside.line) {
    out["line"] = {{"amplitude_N", outside.line->amplitude_N}, {"frequency_Hz", outside.line->frequency_Hz}};
  }
  if (outside.bump) {
    out["bump"] = {{"amplitude_N", outside.bump->amplitude_N},
                   {"centre_m", outside.bump->centre_m},
                   {"width_m", outside.bump->width_m}};
  }
  if (outside.backlash) {
    out["backlash"] = {{"gap_m", outside.backlash->gap_m}, {"motor_share", outside.backlash->motor_share}};
  }
  if (outside.burst) {
    out["burst"] = {{"start_s", outside.burst->start_s},
                    {"duration_s", outside.burst->duration_s},
                    {"amplitude_N", outside.burst->amplitude_N}};
  }
  if (outside.slip) {
    Json losses = Json::array();
    for (const auto& loss : outside.slip->losses)
      losses.push_back({{"time_s", loss.time_s}, {"counts", loss.counts}});
    out["slip"] = losses;
  }
  if (outside.ring) {
    out["ring"] = {{"frequency_Hz", outside.ring->frequency_Hz},
                   {"damping_ratio", outside.ring->damping_ratio},
                   {"share", outside.ring->share},
                   {"rms_N", log.ring_rms_N},
                   {"rms_over_noise", noise_N > 0.0 ? Json(log.ring_rms_N / noise_N) : Json(nullptr)}};
  }
  if (outside.force_filter) {
    out["force_filter"] = {{"cut_Hz", outside.force_filter->cut_Hz},
                           {"half_amplitude_Hz", outside.force_filter->half_Hz()},
                           {"order", outside.force_filter->order},
                           {"zero_phase", outside.force_filter->zero_phase}};
  }
  return out;
}

}  // namespace

std::string truth_as_json(const Axis& axis, const SimulatedLog& log, const TruthContext& context) {
  Sheet sheet;
  describe_friction(axis.effects, sheet);
  describe_others(axis.effects, sheet);
  Json effects = Json::array();
  for (const EffectId id : context.effects) effects.push_back(name(id));
  if (effects.empty()) effects.push_back("none");
  Json rms = Json::object();
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    if (log.parts_rms_N[i] > 0.0) rms[std::string(kEffectNames[i])] = log.parts_rms_N[i];
  }
  Json truth = {
      {"effects", effects},
      {"outside", context.outside.empty() ? Json(nullptr) : Json(context.outside)},
      {"setup", context.setup},
      {"seed", context.seed},
      {"closed_loop", context.closed_loop},
      {"samples", log.size()},
      {"rate_Hz", log.rate_Hz},
      {"mass_kg", axis.mass_kg},
      {"saturation_N", axis.curve.saturation_N()},
      {"presliding_travel_m", axis.curve.travel_m()},
      {"virgin_curve", describe(axis.curve)},
      {"pitch_m", axis.magnet_pitch_m},
      {"stroke_m", axis.stroke_m},
      {"formulas", sheet.formulas},
      {"parameters", sheet.parameters},
      {"outside_parameters", describe(axis.outside, log, axis.force_noise_N)},
      {"noise_N", axis.force_noise_N},
      {"encoder_m", axis.encoder_resolution_m},
      {"effect_rms_N", rms},
      {"force_rms_N", log.force_rms_N},
  };
  return truth.dump(1) + "\n";
}

}  // namespace slipstack::sim
