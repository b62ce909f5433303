// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "workbench/cli/experiment/experiment.h"
#include "workbench/cli/inputs.h"
#include "workbench/cli/results.h"
#include "workbench/diagnose/quantity.h"
#include "workbench/identify/shape_search.h"
#include "workbench/log/text.h"
#include "workbench/plan/plan.h"

namespace slipstack::workbench {
namespace {

/// Of an axis about which nothing is said.
constexpr double kAssumedMass_kg = 10.0;
constexpr double kAssumedFriction_N = 10.0;
constexpr double kAssumedNoise = 0.01;  ///< of the friction
constexpr double kAssumedEncoder_m = 1e-7;
/// Jerk from the acceleration, where it is not given: reached within 20 ms.
constexpr double kJerkTime_s = 0.02;

struct PlanRequest {
  std::string effects;
  std::vector<std::string> logs;
  std::string model;
  std::string baseline;
  std::string limits;
  std::vector<std::string> own_effects;
  double seconds = 60.0;
  double rate_Hz = 1000.0;
  ExperimentOutputs outputs;
};

/// The logs by name, for people.
std::string names_of(const std::vector<std::string>& logs) {
  return fmt::format("{}", fmt::join(logs, ", "));
}

/// "stroke=0.02:0.38,velocity=0.5,...": what was given.
std::map<std::string, std::vector<double>> parse_limits(const std::string& text) {
  std::map<std::string, std::vector<double>> given;
  if (text.empty()) return given;
  const std::vector<std::string> known{"stroke", "velocity", "acceleration", "jerk", "force", "current"};
  for (const std::string_view field : split_fields(text)) {
    const std::size_t equals = field.find('=');
    const std::string key(field.substr(0, equals));
    if (equals == std::string_view::npos || std::find(known.begin(), known.end(), key) == known.end()) {
      throw UsageError(fmt::format("--limits: {} is none of {}=number (stroke=low:high), SI units",
                                   quoted(field), fmt::join(known, "=, ")));
    }
    std::string_view rest = field.substr(equals + 1);
    std::vector<double>& values = given[key];
    while (true) {
      const std::string_view one = rest.substr(0, rest.find(':'));
      double value = 0.0;
      const char* const end = one.data() + one.size();
      if (one.empty() || parse_double(one.data(), end, value) != end || !std::isfinite(value)) {
        throw UsageError(fmt::format("--limits: {} is not a number; as in {}", quoted(one),
                                     key == "stroke" ? "stroke=0.02:0.38" : key + "=1.5"));
      }
      values.push_back(value);
      if (one.size() == rest.size()) break;
      rest.remove_prefix(one.size() + 1);
    }
    const bool pair = key == "stroke" && values.size() == 2 && values[0] < values[1];
    const bool good = pair || (values.size() == 1 && values[0] > 0.0);
    if (!good) {
      throw UsageError(
          fmt::format("--limits: {} must be {}", key,
                      key == "stroke" ? "a length, or low:high with low below high" : "one positive number"));
    }
  }
  return given;
}

/// What the request knows of the axis, and how it is recorded.
struct Known {
  std::unique_ptr<Measurement> measurement;  ///< of long logs an excerpt
  Reached reached;                           ///< in all of the logs
  FittedModel base;                          ///< on the logs; empty without
  Knowledge knowledge;
  std::vector<ExpectedEvidence> so_far;
};

/// `known`: nullptr without a log.
AxisLimits limits_of(const PlanRequest& request, const Known* known) {
  const auto given = parse_limits(request.limits);
  AxisLimits limits;
  if (known != nullptr) {  // what the axis did in the log, it can do again
    limits.low_m = known->reached.low_m;
    limits.high_m = known->reached.high_m;
    limits.velocity_mps = known->reached.velocity_mps;
    limits.acceleration_mps2 = known->reached.acceleration_mps2;
  } else {
    for (const char* key : {"stroke", "velocity", "acceleration"}) {
      if (!given.contains(key)) {
        throw UsageError(fmt::format(
            "--limits: {} is missing; without --log give 'stroke=0.3,velocity=0.5,acceleration=5' "
            "of your axis, in SI units",
            key));
      }
    }
  }
  for (const auto& [key, values] : given) {
    if (key == "stroke") {
      limits.low_m = values.size() == 2 ? values[0] : 0.0;
      limits.high_m = values.back();
    }
    if (key == "velocity") limits.velocity_mps = values[0];
    if (key == "acceleration") limits.acceleration_mps2 = values[0];
    if (key == "force") limits.force_N = values[0];
  }
  if (given.contains("current")) {
    const auto constant = known == nullptr ? std::nullopt : known->measurement->log().motor_constant_N_per_A;
    if (!constant) {
      throw UsageError(
          "--limits: current says nothing without a motor constant; give a log with the line "
          "'# motor_constant_N_per_A: value', or force= instead");
    }
    const double force_N = given.at("current")[0] * *constant;
    limits.force_N = limits.force_N > 0.0 ? std::min(limits.force_N, force_N) : force_N;
  }
  limits.jerk_mps3 = given.contains("jerk") ? given.at("jerk")[0] : limits.acceleration_mps2 / kJerkTime_s;
  return limits;
}

/// An axis of which nothing is known but what rolling guideways have in common: an exponential virgin curve.
Terms assumed_model() {
  Term inertia;
  inertia.effect = find_effect("inertia");
  inertia.gains = inertia.lower = inertia.upper = {kAssumedMass_kg};
  Term hysteresis;
  hysteresis.effect = find_effect("presliding_hysteresis");
  constexpr std::size_t kElements = 10;
  const auto capacity = static_cast<std::size_t>(hysteresis.effect->gain_count);
  hysteresis.shapes = slip_distances(1e-7, 1e-4, kElements, capacity);
  hysteresis.gains.assign(capacity, 0.0);
  for (std::size_t i = 0; i < kElements; ++i) {
    hysteresis.gains[i] = kAssumedFriction_N / kElements / hysteresis.shapes[i];
  }
  hysteresis.lower.assign(capacity, 0.0);
  hysteresis.upper.assign(capacity, static_cast<double>(kUnbounded));
  return {inertia, hysteresis};
}

Term unknown_term(const EffectDescription& effect) {
  Term term;
  term.effect = &effect;
  return term;
}

/// The baseline, beside the effects that are planned for, on the logs.
FittedModel base_of(const PlanRequest& request, const std::vector<std::string>& ids, const Model& model,
                    const Measurement& measurement) {
  const auto planned = [&](const std::string& id) {
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  };
  if (!request.model.empty()) {
    Terms terms = terms_on(measurement, model);
    std::erase_if(terms, [&](const Term& term) { return planned(term.id()); });
    return fit_gains(measurement, std::move(terms));
  }
  std::vector<std::string> baseline =
      parse_effects(request.baseline.empty() ? kDefaultBaseline : request.baseline);
  std::erase_if(baseline, planned);
  if (baseline.empty()) throw UsageError("--effects: nothing is left beside those of --for; name a baseline");
  check_combination(measurement, baseline);
  return fit_effects(measurement, baseline, {});
}

/// What the logs tell: the effects by what is searched of them, the baseline and the limits by the whole.
void know_by_logs(Known& known, const PlanRequest& request, const std::vector<std::string>& ids,
                  const Model& model, Progress& progress) {
  Options as_log;
  as_log.log = names_of(request.logs);
  as_log.logs = request.logs;
  Alone alone;
  as_log.team = &alone;
  Knowledge& knowledge = known.knowledge;
  Searched searched = search(as_log, progress, [&](Measurement& measurement, WholeLogs& whole) {
    progress.show("fit the baseline");
    known.base = base_of(request, ids, model, measurement);
    knowledge.encoder_resolution_m = measurement.encoder_resolution_m();
    knowledge.force_noise_N = measurement.force_noise_N();
    progress.show("try the effects");
    Terms effects;
    for (const std::string& id : ids) {
      effects.push_back(try_effect(measurement, known.base, *find_effect(id), {}).term);
    }
    knowledge.effects = averaged_over_logs(measurement, std::move(effects));
    whole.fit({&known.base}, 0.0, judging(progress));
    known.reached = whole.reached();
    // What the next motion carries is what the logs carried on average.
    knowledge.model = averaged_over_logs(measurement, known.base.terms);
  });
  known.measurement = std::move(searched.measurement);
}

Known known_of(const PlanRequest& request, const std::vector<std::string>& ids, Progress& progress) {
  Known known;
  Model model;
  if (!request.model.empty()) model = read_model(request.model);
  Knowledge& knowledge = known.knowledge;
  knowledge.rate_Hz = request.rate_Hz;
  if (request.logs.empty()) {
    knowledge.model = request.model.empty() ? assumed_model() : model.terms;
    std::erase_if(knowledge.model, [&](const Term& term) {
      return std::find(ids.begin(), ids.end(), term.id()) != ids.end();
    });
    knowledge.encoder_resolution_m = kAssumedEncoder_m;
    knowledge.force_noise_N =
        request.model.empty() ? kAssumedNoise * kAssumedFriction_N : model.source.noise_floor_N;
    for (const std::string& id : ids) knowledge.effects.push_back(unknown_term(*find_effect(id)));
    return known;
  }
  know_by_logs(known, request, ids, model, progress);
  return known;
}

const ExpectedEvidence* find_evidence(const std::vector<ExpectedEvidence>& all,
                                      const ExpectedEvidence& like) {
  for (const ExpectedEvidence& one : all) {
    if (one.effect == like.effect && one.other == like.other) return &one;
  }
  return nullptr;
}

ExperimentTable evidence_table(const Plan& plan, const std::vector<ExpectedEvidence>& so_far) {
  ExperimentTable table{"evidence",
                        "Expected evidence",
                        {{"effect", "effect", ""},
                         {"other", "told from", ""},
                         {"log_angle_deg", "angle, log", "deg", 1.0, 3},
                         {"angle_deg", "angle, plan", "deg", 1.0, 3},
                         {"log_evidence", "evidence, log", "", 1.0, 3},
                         {"evidence", "evidence, plan", "", 1.0, 3}},
                        {}};
  const double none = std::nan("");
  for (const ExpectedEvidence& one : plan.expected) {
    const ExpectedEvidence* log = find_evidence(so_far, one);
    table.rows.push_back({one.effect, one.other.empty() ? std::string("nothing") : one.other,
                          log == nullptr ? none : log->angle_deg, one.angle_deg,
                          log == nullptr ? none : log->evidence, one.evidence});
  }
  return table;
}

ExperimentTable pieces_table(const Plan& plan) {
  ExperimentTable table{"pieces", "The motion", {{"piece", "#", "", 1.0, 0}, {"what", "what", ""}}, {}};
  for (std::size_t i = 0; i < plan.pieces.size(); ++i) {
    table.rows.push_back({static_cast<double>(i + 1), plan.pieces[i]});
  }
  return table;
}

ExperimentResult plan_result(const PlanRequest& request, const Known& known, const AxisLimits& limits,
                             const Plan& plan) {
  const AxisLimits reached = extremes_of(plan.motion);
  ExperimentResult result;
  result.experiment = "plan";
  result.setup = request.logs.empty()
                     ? request.model.empty() ? "an axis of which only the limits are known" : request.model
                     : names_of(request.logs);
  const auto weakest = std::min_element(plan.expected.begin(), plan.expected.end(),
                                        [](const auto& a, const auto& b) { return a.evidence < b.evidence; });
  result.headline =
      fmt::format("{:.1f} s of motion; the least evidence that it is expected to give is {:.3g}, {} {}.",
                  plan.motion.duration_s(), weakest->evidence, weakest->effect,
                  weakest->other.empty() ? std::string("beside the baseline") : "against " + weakest->other);
  result.detail =
      "Evidence is the expected difference of BIC if the axis has the effect: above 10 it is decisive, below "
      "0 the "
      "other would be named. An effect that contains another can always imitate it.";
  result.summary = {
      {"for", request.effects},
      {"duration_s", plan.motion.duration_s()},
      {"rate_Hz", plan.motion.rate_Hz},
      {"low_m", reached.low_m},
      {"high_m", reached.high_m},
      {"velocity_mps", reached.velocity_mps},
      {"acceleration_mps2", reached.acceleration_mps2},
      {"jerk_mps3", reached.jerk_mps3},
      {"force_N", number_json(plan.peak_force_N)},
      {"limits",
       {{"low_m", limits.low_m},
        {"high_m", limits.high_m},
        {"velocity_mps", limits.velocity_mps},
        {"acceleration_mps2", limits.acceleration_mps2},
        {"jerk_mps3", limits.jerk_mps3},
        {"force_N", limits.force_N > 0.0 ? nlohmann::json(limits.force_N) : nlohmann::json()}}}};
  result.tables = {evidence_table(plan, known.so_far), pieces_table(plan)};
  std::vector<double> time_s(plan.motion.size());
  for (std::size_t i = 0; i < time_s.size(); ++i) time_s[i] = static_cast<double>(i) / plan.motion.rate_Hz;
  result.charts.push_back({"Set points",
                           {"Time", "s", 1.0, false},
                           {"Position", "mm", 1e3, false},
                           time_s,
                           {{"position", plan.motion.position_m, {}, "measured", false}},
                           false});
  result.notes.push_back(fmt::format("Reached: {} to {}, {}, {:.3g} m/s2, {:.3g} m/s3, {} by the model.",
                                     quantity(reached.low_m, "m"), quantity(reached.high_m, "m"),
                                     quantity(reached.velocity_mps, "m/s"), reached.acceleration_mps2,
                                     reached.jerk_mps3, newtons(plan.peak_force_N)));
  if (request.logs.empty() && request.model.empty()) {
    result.notes.push_back(
        fmt::format("Assumed: {} kg, {} N of friction, noise {} % of it; give --log or --model.",
                    kAssumedMass_kg, kAssumedFriction_N, 100.0 * kAssumedNoise));
  }
  result.file =
      to_csv(plan.motion, {"what: set points of slipstack experiment plan", "for: " + request.effects,
                           fmt::format("sample_rate_Hz: {:g}", plan.motion.rate_Hz)});
  return result;
}

void run_plan(const Options& options, const PlanRequest& request) {
  Options own;
  own.own_effects = request.own_effects;
  declared_effects(own);
  const std::vector<std::string> ids = parse_effects(request.effects);
  for (const std::string& id : ids) {
    const EffectDescription& effect = *find_effect(id);
    if (effect.gain_count == 0 || id == "inertia" || id == "presliding_hysteresis") {
      throw UsageError(fmt::format("--for: no experiment can be planned for {}; name another effect", id));
    }
  }
  if (!(request.seconds >= 5.0 && request.seconds <= 3600.0))
    throw UsageError("--seconds: must be between 5 and 3600");
  if (!(request.rate_Hz >= 200.0 && request.rate_Hz <= 20000.0)) {
    throw UsageError("--rate: must be between 200 and 20000 Hz");
  }
  parse_limits(request.limits);
  std::vector<std::string> inputs = request.logs;
  inputs.push_back(request.model);
  deliver(options, request.outputs, inputs, [&](Progress& progress) {
    AxisLimits limits;
    if (request.logs.empty()) limits = limits_of(request, nullptr);
    Known known = known_of(request, ids, progress);
    if (known.measurement) limits = limits_of(request, &known);
    const Plan plan = plan_experiment(
        known.knowledge, {limits, request.seconds, [&](const std::string& stage, double fraction) {
                            progress.show(stage, fraction);
                          }});
    if (known.measurement) known.so_far = expected_evidence(*known.measurement, known.base, plan.effects);
    return plan_result(request, known, limits, plan);
  });
}

}  // namespace

void define_plan(CLI::App& experiment, const Options& options) {
  CLI::App* command = experiment.add_subcommand(
      "plan", "Plan the motion that tells effects apart, within the limits of the axis");
  auto request = std::make_shared<PlanRequest>();
  add_word(*command, "--for", request->effects, "A,B,..", "effects to show and to tell apart")->required();
  command
      ->add_option("--log", request->logs,
                   "what is known so far: model, noise, and limits where not given; several of one axis")
      ->type_name("FILE...")
      ->expected(1, -1)
      ->take_all();
  CLI::Option* model = add_word(*command, "--model", request->model, "FILE", "model of the axis");
  add_word(*command, "--effects", request->baseline, "A,B,..",
           "baseline on the log (default: inertia,presliding_hysteresis)")
      ->excludes(model);
  command->add_option("--effect", request->own_effects, "an effect of your own that --for names")
      ->type_name("DEFINITION")
      ->allow_extra_args(false)
      ->take_all();
  add_word(*command, "--limits", request->limits, "K=V,..",
           "stroke=low:high,velocity=,acceleration=,jerk=,force=,current= in SI units (default: the log's "
           "motion; no force)");
  command->add_option("--seconds", request->seconds, "the motion may last")->capture_default_str();
  command->add_option("--rate", request->rate_Hz, "set points per second")->capture_default_str();
  add_word(*command, "--out", request->outputs.out, "FILE", "set-point file to write, CSV")->required();
  add_experiment_outputs(*command, request->outputs);
  command->callback([&options, request] { run_plan(options, *request); });
}

}  // namespace slipstack::workbench
