// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/blind/cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "sim_host/log/closed_loop.h"
#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/log/write.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/identify/noise_floor.h"
#include "workbench/identify/standard_errors.h"
#include "workbench/log/log.h"

namespace slipstack::bench {
namespace {

using nlohmann::json;

constexpr std::array<const char*, 9> kNames{"clean", "single",   "pair",  "triple", "line",
                                            "bump",  "backlash", "burst", "slip"};

std::optional<sim::OutsideKind> outside_of(Kind kind) {
  return sim::outside_by_name(name_of(kind));
}

std::size_t hidden_count(Kind kind) {
  return kind == Kind::single ? 1 : kind == Kind::pair ? 2 : kind == Kind::triple ? 3 : 0;
}

struct Written {
  std::filesystem::path log;
  json truth;
};

Written write_log(Kind kind, std::uint64_t seed, bool closed_loop, const std::filesystem::path& folder) {
  sim::Bench bench = sim::draw_bench(sim::Setup::kRandom, seed);
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  const auto effects = sim::draw_effect_ids(hidden_count(kind), seed);
  sim::add_effects(bench.axis, effects, programme, bench.rate_Hz, 0.0, seed);
  if (const auto outside = outside_of(kind)) {
    sim::add_outside(bench.axis, *outside, programme, bench.rate_Hz, 0.0, seed);
  }
  const sim::SimulatedLog log =
      closed_loop ? sim::simulate_closed_loop_log(bench.axis, programme, bench.rate_Hz, seed)
                  : sim::simulate_log(bench.axis, programme, bench.rate_Hz, seed);
  const std::filesystem::path path = folder / "log.csv";
  sim::write_file(path.string(), sim::log_as_csv(bench.axis, log));
  return {path, json::parse(sim::truth_as_json(bench.axis, log, {"random", seed, closed_loop, effects, ""}))};
}

/// Parameters that plant and model define alike: effect, its formula in the plant, the key there, shape or
/// gain here.
struct Known {
  const char* effect;
  const char* formula;
  const char* key;
  bool shape;
};
constexpr std::array<Known, 6> kKnown{{{"viscous", "linear", "coefficient_N_s_per_m", false},
                                       {"offset_force", "constant", "force_N", false},
                                       {"payload_mass", "mass", "mass_kg", false},
                                       {"force_ripple", "harmonics", "pitch_m", true},
                                       {"structural_resonance", "mass_on_spring", "frequency_Hz", true},
                                       {"time_delay", "delay", "delay_s", true}}};

std::vector<double> deviations(const workbench::Terms& terms, const json& truth) {
  std::vector<double> found;
  for (const Known& known : kKnown) {
    const workbench::Term* term = workbench::find_term(terms, known.effect);
    const json& formulas = truth["formulas"];
    if (term == nullptr || !formulas.contains(known.effect) || formulas[known.effect] != known.formula)
      continue;
    const double value = known.shape ? term->shapes[0] : term->gains[0];
    const double error = known.shape ? term->shape_standard_errors[0] : term->gain_standard_errors[0];
    if (error > 0.0)
      found.push_back((value - truth["parameters"][known.effect][known.key].get<double>()) / error);
  }
  return found;
}

}  // namespace

const char* name_of(Kind kind) {
  return kNames[static_cast<std::size_t>(kind)];
}

bool outside_catalogue(Kind kind) {
  return outside_of(kind).has_value();
}

bool Outcome::right() const {
  if (kind == Kind::clean) return verdict == "complete";
  if (outside_catalogue(kind)) return verdict == "unexplained";
  std::vector<std::string> wanted = hidden;
  std::vector<std::string> named = added;
  std::sort(wanted.begin(), wanted.end());
  std::sort(named.begin(), named.end());
  return verdict == "missing_effect" && wanted == named;
}

Outcome run_case(Kind kind, std::uint64_t seed, bool closed_loop, const std::filesystem::path& folder) {
  const Written written = write_log(kind, seed, closed_loop, folder);
  workbench::Measurement measurement(workbench::read_log(written.log));
  workbench::weigh_rows(measurement);
  const workbench::Diagnosis diagnosis = workbench::diagnose(
      measurement, {.baseline = {"inertia", "presliding_hysteresis"}, .start = {}, .progress = {}});
  Outcome outcome;
  outcome.kind = kind;
  outcome.seed = seed;
  outcome.closed_loop = closed_loop;
  for (const json& effect : written.truth["effects"]) {
    if (effect != "none") outcome.hidden.push_back(effect);
  }
  outcome.verdict = workbench::name_of(diagnosis.verdict);
  for (const auto& candidate : diagnosis.candidates) outcome.ranking.push_back(candidate.term.id());
  for (std::size_t i = 1; i < diagnosis.steps.size(); ++i) outcome.added.push_back(diagnosis.steps[i].added);
  if (diagnosis.unexplained) outcome.coordinate = diagnosis.unexplained->coordinate;
  outcome.baseline_over_floor = diagnosis.baseline.holdout_rmse_N / diagnosis.noise_floor_N;
  outcome.explained_over_floor = diagnosis.explained.holdout_rmse_N / diagnosis.noise_floor_N;
  outcome.deviations =
      deviations(workbench::with_standard_errors(measurement, diagnosis.explained).terms, written.truth);
  return outcome;
}

json to_json(const Outcome& outcome) {
  return {{"kind", name_of(outcome.kind)},
          {"seed", outcome.seed},
          {"closed_loop", outcome.closed_loop},
          {"hidden", outcome.hidden},
          {"verdict", outcome.verdict},
          {"ranking", outcome.ranking},
          {"added", outcome.added},
          {"coordinate", outcome.coordinate},
          {"baseline_over_floor", outcome.baseline_over_floor},
          {"explained_over_floor", outcome.explained_over_floor},
          {"deviations", outcome.deviations}};
}

Outcome outcome_from(const json& entry) {
  Outcome outcome;
  const auto name = std::find(kNames.begin(), kNames.end(), entry.at("kind").get<std::string>());
  if (name == kNames.end()) throw std::runtime_error("unknown kind");
  outcome.kind = static_cast<Kind>(name - kNames.begin());
  outcome.seed = entry.at("seed");
  outcome.closed_loop = entry.at("closed_loop");
  outcome.hidden = entry.at("hidden");
  outcome.verdict = entry.at("verdict");
  outcome.ranking = entry.at("ranking");
  outcome.added = entry.at("added");
  outcome.coordinate = entry.at("coordinate");
  outcome.baseline_over_floor = entry.at("baseline_over_floor");
  outcome.explained_over_floor = entry.at("explained_over_floor");
  outcome.deviations = entry.at("deviations").get<std::vector<double>>();
  return outcome;
}

}  // namespace slipstack::bench
