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
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/long_logs/log_search.h"

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

Written write_log(Kind kind, std::uint64_t seed, bool closed_loop, const std::filesystem::path& path) {
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
  sim::write_file(path.string(), sim::log_as_csv(bench.axis, log));
  return {path, json::parse(sim::truth_as_json(bench.axis, log, {"random", seed, closed_loop, effects, ""}))};
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
  // Not two findings: a chain whose unloaded place is not known has any constant force.
  if (std::find(wanted.begin(), wanted.end(), "cable_chain_stiffness") != wanted.end())
    std::erase(wanted, "offset_force");
  std::sort(wanted.begin(), wanted.end());
  std::sort(named.begin(), named.end());
  return verdict == "missing_effect" && wanted == named;
}

Outcome run_case(Kind kind, std::uint64_t seed, bool closed_loop, const std::filesystem::path& path) {
  const Written written = write_log(kind, seed, closed_loop, path);
  // As `diagnose` reads logs: long ones are searched in an excerpt and judged by all samples.
  workbench::SingleProcess alone;
  workbench::Progress progress;
  workbench::LogSearch logs({&alone, {written.log}, {}}, progress);
  workbench::DiagnoseOptions options;
  options.baseline = {"inertia", "presliding_hysteresis"};
  const workbench::Diagnosis diagnosis = logs.diagnose(options);
  const workbench::Measurement& measurement = logs.measurement();
  Outcome outcome;
  outcome.kind = kind;
  outcome.seed = seed;
  outcome.closed_loop = closed_loop;
  for (const json& effect : written.truth["effects"]) {
    if (effect != "none") outcome.hidden.push_back(effect);
  }
  outcome.verdict = workbench::name_of(diagnosis.verdict);
  for (const auto& candidate : diagnosis.candidates) outcome.ranking.push_back(candidate.term.id());
  for (std::size_t i = 1; i < diagnosis.steps.size(); ++i) outcome.added.push_back(diagnosis.steps[i].effect);
  if (diagnosis.unexplained) outcome.coordinate = name_of(diagnosis.unexplained->coordinate);
  outcome.baseline_over_floor = diagnosis.baseline.holdout_rmse_N / diagnosis.noise_floor_N;
  outcome.explained_over_floor = diagnosis.explained.holdout_rmse_N / diagnosis.noise_floor_N;
  outcome.estimates =
      estimates_of(workbench::with_standard_errors(measurement, diagnosis.explained).terms, written.truth);
  return outcome;
}

json to_json(const Outcome& outcome) {
  json estimated = json::array();
  for (const Estimate& one : outcome.estimates) {
    estimated.push_back({{"parameter", one.parameter},
                         {"truth", one.truth},
                         {"value", one.value},
                         {"standard_error", one.standard_error}});
  }
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
          {"estimates", std::move(estimated)}};
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
  for (const json& one : entry.at("estimates")) {
    outcome.estimates.push_back(
        {one.at("parameter"), one.at("truth"), one.at("value"), one.at("standard_error")});
  }
  return outcome;
}

}  // namespace slipstack::bench
