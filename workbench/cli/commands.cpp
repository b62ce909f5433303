// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/commands.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "workbench/cli/output.h"
#include "workbench/cli/progress.h"
#include "workbench/cli/tables.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/quantity.h"
#include "workbench/identify/noise_floor.h"
#include "workbench/identify/reduce.h"
#include "workbench/model/model.h"
#include "workbench/report/html.h"
#include "workbench/report/report_data.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

std::string rmse(double value_N) {
  return quantity(value_N, "N");
}

/// Ids of a comma-separated list, each known and named once.
std::vector<std::string> parse_effects(const std::string& list) {
  std::vector<std::string> ids;
  std::stringstream stream(list);
  for (std::string id; std::getline(stream, id, ',');) {
    if (find_effect(id) == nullptr) {
      throw UsageError(fmt::format("unknown effect '{}'; known: {}", id, known_effects()));
    }
    if (std::find(ids.begin(), ids.end(), id) != ids.end()) {
      throw UsageError(fmt::format("effect '{}' is named twice; name it once", id));
    }
    ids.push_back(id);
  }
  if (ids.empty())
    throw UsageError("no effect named; name some, as in --effects inertia,presliding_hysteresis");
  return ids;
}

/// Combinations that no data can separate or that have nothing to act on.
void check_combination(const Measurement& measurement, const std::vector<std::string>& ids) {
  const auto has = [&](std::string_view id) { return std::find(ids.begin(), ids.end(), id) != ids.end(); };
  if (has("inertia") && has("payload_mass") && !measurement.log().mass_kg) {
    throw UsageError(
        "payload_mass and inertia are one and the same while the mass is not known; add `# mass_kg:` to the "
        "log "
        "or leave payload_mass out");
  }
  const bool dry = has("presliding_hysteresis") || has("coulomb");
  for (const std::string& id : ids) {
    if (!dry && find_effect(id)->acts_as(Acts::dry_scale)) {
      throw UsageError(
          fmt::format("{} changes the level of dry friction, and the model has none; add "
                      "presliding_hysteresis or coulomb",
                      id));
    }
  }
}

Measurement measure(const Options& options, Progress& progress) {
  progress.show("read the log", 0.0);
  Measurement measurement(read_log(options.log));
  const Eigen::Index least = 100;
  if (measurement.row_count() < least) {
    throw InputError(fmt::format(
        "{}: {} samples leave {} instants after filtering, fewer than the {} that a fit needs; record longer",
        options.log, measurement.sample_count(), measurement.row_count(), least));
  }
  return measurement;
}

void check_enough(const Options& options, const Measurement& measurement, const Terms& terms) {
  if (measurement.row_count() <= unknown_count(terms)) {
    throw InputError(
        fmt::format("{}: {} instants cannot tell {} parameters; record longer or fit fewer effects",
                    options.log, measurement.row_count(), unknown_count(terms)));
  }
}

Terms terms_for(const Measurement& measurement, const std::vector<std::string>& ids) {
  Terms terms;
  for (const std::string& id : ids) terms.push_back(term_for_log(measurement, *find_effect(id)));
  return terms;
}

/// Terms of a model file, for this log: its mass is the log's where the log declares one.
Terms terms_on(const Measurement& measurement, const Model& model) {
  Terms terms = model.terms;
  for (Term& term : terms) {
    if (term.id() == "inertia" && measurement.log().mass_kg) {
      term.gains[0] = term.lower[0] = term.upper[0] = *measurement.log().mass_kg;
    }
  }
  return terms;
}

std::vector<std::string> ids_of(const Terms& terms) {
  std::vector<std::string> ids;
  for (const Term& term : terms) ids.push_back(term.id());
  return ids;
}

ForceRows rows_of(const FittedModel& fitted) {
  return {fitted.linearisation->measured_N(), fitted.linearisation->force_N()};
}

json report_base(const Options& options, const std::string& command) {
  return {{"title", "slipstack " + command}, {"command", "slipstack " + command}, {"log", options.log}};
}

/// The model file of a fit, with the hysteresis reduced to the controller's elements.
Model model_of(const Options& options, const Measurement& measurement, const FittedModel& fitted,
               double floor_N) {
  const FittedModel reduced = reduce_hysteresis(measurement, fitted, kTargetElements);
  Model model;
  model.source = {options.log, static_cast<std::int64_t>(measurement.sample_count()), fitted.holdout_rmse_N,
                  floor_N, fitted.relative_error};
  model.terms = fitted.terms;
  model.target_terms = reduced.terms;
  model.target_holdout_rmse_N = reduced.holdout_rmse_N;
  return model;
}

void print_model_written(const std::string& path, const Model& model) {
  fmt::print("\nmodel      {}, hash {:08x}\n", path, target_hash(model));
  if (find_term(model.terms, "presliding_hysteresis") != nullptr) {
    fmt::print("controller {} hysteresis elements: held-out error {} instead of {}\n", kTargetElements,
               rmse(model.target_holdout_rmse_N), rmse(model.source.holdout_rmse_N));
  }
}

json quality_json(const Measurement& measurement, const FittedModel& fitted, double floor_N) {
  return {{"samples", measurement.sample_count()},
          {"effects", ids_of(fitted.terms)},
          {"noise_floor_N", number_json(floor_N)},
          {"train_rmse_N", number_json(fitted.train_rmse_N)},
          {"holdout_rmse_N", number_json(fitted.holdout_rmse_N)},
          {"relative_error", number_json(fitted.relative_error)},
          {"parameters", parameters_json(fitted.terms)}};
}

json figures_json(const FittedModel& fitted, double floor_N) {
  return {{"noise_floor_N", number_json(floor_N)},
          {"train_rmse_N", number_json(fitted.train_rmse_N)},
          {"holdout_rmse_N", number_json(fitted.holdout_rmse_N)},
          {"relative_error", number_json(fitted.relative_error)}};
}

std::string share(double value) {
  return fmt::format("{:.2f} %", 100.0 * value);
}

}  // namespace

void run_compare(const Options& options) {
  Outputs outputs;
  outputs.claim(options.report);
  outputs.claim(options.json);
  Progress progress;
  const Model model = read_model(options.model);
  const Measurement measurement = measure(options, progress);
  progress.show("compare", 0.5);
  const NoiseFloor noise(measurement);
  const ForceRows rows{measurement.force_N(delay_s(model.terms)),
                       measurement.filtered(evaluate_force(measurement, model.terms).force_N)};
  const Eigen::VectorXd residual = rows.residual_N();
  const double error_N = std::sqrt(residual.squaredNorm() / static_cast<double>(residual.size()));
  const double relative = residual.norm() / std::max(rows.measured_N.norm(), 1e-300);
  const double floor_N = noise.of(model.terms);
  const auto structure = find_structure(measurement, residual);
  const std::string left = structure.front().error_reduction > 0.05
                               ? structure.front().description
                               : "nothing that depends on one coordinate";

  fmt::print("log        {}\nmodel      {}, hash {:08x}\neffects    {}\n", options.log, options.model,
             target_hash(model), fmt::join(ids_of(model.terms), ", "));
  fmt::print("error      {} rms, {} of the force; noise floor {}\nleft       {}\n", rmse(error_N),
             share(relative), rmse(floor_N), left);

  json result{{"log", options.log},
              {"model", options.model},
              {"hash", fmt::format("{:08x}", target_hash(model))},
              {"samples", measurement.sample_count()},
              {"effects", ids_of(model.terms)},
              {"rmse_N", number_json(error_N)},
              {"relative_error", number_json(relative)},
              {"noise_floor_N", number_json(floor_N)},
              {"left", left}};
  if (!options.report.empty()) {
    json data = report_base(options, "compare");
    data["verdict"] = {
        {"kind", "comparison"},
        {"headline", fmt::format("The model misses the measured force by {} rms, {} of it; the noise "
                                 "floor is {}.",
                                 rmse(error_N), share(relative), rmse(floor_N))},
        {"detail", "What is left: " + left + "."}};
    data["figures"] = {{"noise_floor_N", number_json(floor_N)},
                       {"train_rmse_N", number_json(error_N)},
                       {"relative_error", number_json(relative)}};
    data["baseline_effects"] = ids_of(model.terms);
    data["parameters"] = parameters_json(model.terms);
    add_pictures(data, measurement, rows, nullptr);
    outputs.set(options.report, render_report(data));
  }
  outputs.set(options.json, result.dump(1) + "\n");
  outputs.commit();
}

void run_fit(const Options& options) {
  const std::vector<std::string> ids = parse_effects(options.effects);
  Outputs outputs;
  outputs.claim(options.model);
  outputs.claim(options.report);
  outputs.claim(options.json);
  Progress progress;
  const Measurement measurement = measure(options, progress);
  check_combination(measurement, ids);
  check_enough(options, measurement, terms_for(measurement, ids));
  progress.show("fit", 0.2);
  const FittedModel fitted = fit_effects(measurement, ids, {});
  progress.show("reduce to the controller", 0.8);
  const double floor_N = NoiseFloor(measurement).of(fitted.terms);
  const Model model = model_of(options, measurement, fitted, floor_N);

  fmt::print("log        {}\neffects    {}\n", options.log, fmt::join(ids, ", "));
  fmt::print("error      {} held out, {} in sample, {} of the force; noise floor {}\n",
             rmse(fitted.holdout_rmse_N), rmse(fitted.train_rmse_N), share(fitted.relative_error),
             rmse(floor_N));
  print_parameters(fitted.terms);
  print_model_written(options.model, model);

  json result = quality_json(measurement, fitted, floor_N);
  result["log"] = options.log;
  result["model"] = options.model;
  result["hash"] = fmt::format("{:08x}", target_hash(model));
  if (!options.report.empty()) {
    json data = report_base(options, "fit");
    data["verdict"] = {{"kind", "fit"},
                       {"headline", fmt::format("Fitted: {} held-out error, noise floor {}.",
                                                rmse(fitted.holdout_rmse_N), rmse(floor_N))},
                       {"detail", ""}};
    data["figures"] = figures_json(fitted, floor_N);
    data["baseline_effects"] = ids;
    data["parameters"] = parameters_json(fitted.terms);
    add_pictures(data, measurement, rows_of(fitted), nullptr);
    outputs.set(options.report, render_report(data));
  }
  outputs.set(options.model, to_toml(model));
  outputs.set(options.json, result.dump(1) + "\n");
  outputs.commit();
}

namespace {

struct Headline {
  std::string line;
  std::string detail;
};

Headline headline_of(const Diagnosis& diagnosis) {
  const std::string floor = rmse(diagnosis.noise_floor_N);
  const std::string before = rmse(diagnosis.baseline.holdout_rmse_N);
  if (diagnosis.verdict == Verdict::complete) {
    return {
        fmt::format("Complete: held-out error {}, noise floor {}.", before, floor),
        "No effect of the catalogue earns its parameters on data that the fit has not seen, and nothing that "
        "depends on one coordinate is left."};
  }
  if (diagnosis.verdict == Verdict::unexplained) {
    return {fmt::format("Unexplained: held-out error {}, noise floor {}.", before, floor),
            diagnosis.unexplained
                ? "No effect of the catalogue accounts for it; " + diagnosis.unexplained->description + "."
                : "No effect of the catalogue accounts for it."};
  }
  const Candidate& first = diagnosis.candidates.front();
  Headline headline{
      fmt::format("Missing: {}. Adding it lowers the held-out error from {} to {}; noise floor {}.",
                  first.term.effect->text.title, before, rmse(diagnosis.best.holdout_rmse_N), floor),
      "Why: " + first.evidence + "."};
  if (diagnosis.steps.size() > 2) {
    headline.detail += " Not alone: with ";
    for (std::size_t i = 2; i < diagnosis.steps.size(); ++i) {
      headline.detail += (i > 2 ? ", " : "") + diagnosis.steps[i].added;
    }
    headline.detail += fmt::format(" the error falls to {}.", rmse(diagnosis.steps.back().holdout_rmse_N));
  }
  if (diagnosis.unexplained) headline.detail += " Still open: " + diagnosis.unexplained->description + ".";
  return headline;
}

json diagnosis_json(const Options& options, const Measurement& measurement, const Diagnosis& diagnosis) {
  json result{{"log", options.log},
              {"samples", measurement.sample_count()},
              {"baseline_effects", ids_of(diagnosis.baseline.terms)},
              {"noise_floor_N", number_json(diagnosis.noise_floor_N)},
              {"baseline",
               {{"train_rmse_N", number_json(diagnosis.baseline.train_rmse_N)},
                {"holdout_rmse_N", number_json(diagnosis.baseline.holdout_rmse_N)},
                {"relative_error", number_json(diagnosis.baseline.relative_error)}}},
              {"verdict", name_of(diagnosis.verdict)},
              {"candidates", candidates_json(diagnosis)},
              {"unexplained", nullptr}};
  if (diagnosis.steps.size() > 1) {
    result["best"] = {{"effects", ids_of(diagnosis.best.terms)},
                      {"train_rmse_N", number_json(diagnosis.best.train_rmse_N)},
                      {"holdout_rmse_N", number_json(diagnosis.best.holdout_rmse_N)},
                      {"relative_error", number_json(diagnosis.best.relative_error)}};
  }
  if (options.stepwise) result["steps"] = steps_json(diagnosis);
  if (diagnosis.unexplained) {
    result["unexplained"] = {{"coordinate", diagnosis.unexplained->coordinate},
                             {"description", diagnosis.unexplained->description}};
  }
  return result;
}

json diagnosis_report(const Options& options, const Measurement& measurement, const Diagnosis& diagnosis,
                      const json& result) {
  const Headline headline = headline_of(diagnosis);
  const bool found = diagnosis.verdict == Verdict::missing_effect;
  const FittedModel& shown = !found             ? diagnosis.baseline
                             : options.stepwise ? diagnosis.explained
                                                : diagnosis.best;
  json data = report_base(options, "diagnose");
  data["verdict"] = {
      {"kind", name_of(diagnosis.verdict)}, {"headline", headline.line}, {"detail", headline.detail}};
  data["figures"] = figures_json(diagnosis.baseline, diagnosis.noise_floor_N);
  if (found) data["figures"]["after_rmse_N"] = number_json(shown.holdout_rmse_N);
  data["baseline_effects"] = result["baseline_effects"];
  data["candidates"] = result["candidates"];
  data["steps"] = steps_json(diagnosis);
  data["unexplained"] = result["unexplained"];
  data["parameters"] = parameters_json(shown.terms);
  const ForceRows before = rows_of(diagnosis.baseline);
  const ForceRows after = rows_of(shown);
  add_pictures(data, measurement, before, found ? &after : nullptr);
  return data;
}

}  // namespace

void run_diagnose(const Options& options) {
  DiagnoseOptions wanted;
  Outputs outputs;
  outputs.claim(options.report);
  outputs.claim(options.json);
  Model model;
  if (!options.model.empty()) model = read_model(options.model);
  const std::vector<std::string> ids =
      options.model.empty()
          ? parse_effects(options.effects.empty() ? "inertia,presliding_hysteresis" : options.effects)
          : ids_of(model.terms);
  Progress progress;
  const Measurement measurement = measure(options, progress);
  check_combination(measurement, ids);
  wanted.baseline = ids;
  if (!options.model.empty()) wanted.start = terms_on(measurement, model);
  wanted.progress = [&progress](const std::string& stage, double fraction) {
    progress.show(stage, fraction);
  };
  check_enough(options, measurement, terms_for(measurement, ids));
  const Diagnosis diagnosis = diagnose(measurement, wanted);

  const Headline headline = headline_of(diagnosis);
  fmt::print("{}\n{}\n", headline.line, headline.detail);
  print_candidates(diagnosis);
  if (options.stepwise) print_steps(diagnosis);
  if (diagnosis.verdict == Verdict::missing_effect) print_advice(diagnosis.candidates.front());

  const json result = diagnosis_json(options, measurement, diagnosis);
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(diagnosis_report(options, measurement, diagnosis, result)));
  }
  outputs.set(options.json, result.dump(1) + "\n");
  outputs.commit();
}

void run_add(const Options& options) {
  const EffectDescription* effect = find_effect(options.effect);
  if (effect == nullptr) {
    throw UsageError(fmt::format("unknown effect '{}'; known: {}", options.effect, known_effects()));
  }
  Outputs outputs;
  outputs.claim(options.out);
  outputs.claim(options.report);
  outputs.claim(options.json);
  const Model old = read_model(options.model);
  if (contains(old.terms, options.effect)) {
    throw UsageError(
        fmt::format("{} already contains {}; add another effect", options.model, options.effect));
  }
  Progress progress;
  const Measurement measurement = measure(options, progress);
  std::vector<std::string> ids = ids_of(old.terms);
  ids.push_back(options.effect);
  check_combination(measurement, ids);
  check_enough(options, measurement, terms_for(measurement, ids));

  progress.show("fit the model as it is", 0.1);
  const FittedModel before = fit_gains(measurement, terms_on(measurement, old));
  progress.show("add the effect", 0.3);
  const Trial trial = try_effect(measurement, before, *effect, {});
  const FittedModel after = polish_shapes(measurement, fit_gains(measurement, trial.terms, &before), {});
  progress.show("reduce to the controller", 0.8);
  const double floor_N = NoiseFloor(measurement).of(after.terms);
  const Model model = model_of(options, measurement, after, floor_N);
  const std::string headline =
      fmt::format("Added {}: held-out error {} before, {} after; noise floor {}.", effect->text.title,
                  rmse(before.holdout_rmse_N), rmse(after.holdout_rmse_N), rmse(floor_N));
  fmt::print("{}\n", headline);
  if (after.holdout_rmse_N > 0.97 * before.holdout_rmse_N) {
    fmt::print("It does not earn its parameters: less than 3 % on data that the fit has not seen.\n");
  }
  print_parameters(after.terms);
  print_model_written(options.out, model);

  json result = quality_json(measurement, after, floor_N);
  result["log"] = options.log;
  result["model"] = options.out;
  result["added"] = options.effect;
  result["hash"] = fmt::format("{:08x}", target_hash(model));
  result["before"] = {{"train_rmse_N", number_json(before.train_rmse_N)},
                      {"holdout_rmse_N", number_json(before.holdout_rmse_N)},
                      {"relative_error", number_json(before.relative_error)}};
  if (!options.report.empty()) {
    json data = report_base(options, "add");
    data["verdict"] = {{"kind", "added"}, {"headline", headline}, {"detail", ""}};
    data["figures"] = figures_json(before, floor_N);
    data["figures"]["after_rmse_N"] = number_json(after.holdout_rmse_N);
    data["baseline_effects"] = ids_of(before.terms);
    data["steps"] = {{{"added", "baseline"}, {"holdout_rmse_N", number_json(before.holdout_rmse_N)}},
                     {{"added", options.effect}, {"holdout_rmse_N", number_json(after.holdout_rmse_N)}}};
    data["parameters"] = parameters_json(after.terms);
    const ForceRows rows_after = rows_of(after);
    add_pictures(data, measurement, rows_of(before), &rows_after);
    outputs.set(options.report, render_report(data));
  }
  outputs.set(options.out, to_toml(model));
  outputs.set(options.json, result.dump(1) + "\n");
  outputs.commit();
}

}  // namespace slipstack::workbench
