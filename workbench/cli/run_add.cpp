// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "workbench/base/text.h"
#include "workbench/cli/commands.h"
#include "workbench/cli/inputs.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/nonlinear/checks.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/model/effects/user_effect.h"
#include "workbench/report/html.h"
#include "workbench/report/results.h"
#include "workbench/report/text_tables.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// The one effect that --effect names.
const EffectDescription& effect_of(const Options& options) {
  return is_definition(options.effect) ? declare_effect(options.effect) : effect_named(options.effect);
}

Model model_to_extend(const Options& options, const EffectDescription& effect) {
  Model model = read_model(options.model);
  if (contains(model.terms, effect.text.id)) {
    throw UsageError(
        fmt::format("{} already contains {}; add another effect", printable(options.model), effect.id()));
  }
  return model;
}

struct Addition {
  std::string effect;
  FittedModel before;
  FittedModel after;
  FittedModel reduced;  ///< to what the controller runs
  double floor_N = 0.0;
  std::string headline;
};

Addition added(LogSearch& logs, const Model& old, const EffectDescription& effect, Progress& progress) {
  const Measurement& measurement = logs.measurement();
  Addition result;
  result.effect = effect.id();
  progress.show("fit the model as it is");
  result.before = fit_gains(measurement, terms_on(measurement, old.terms));
  progress.show("add the effect");
  const Trial trial = try_effect(measurement, result.before, effect, {});
  result.after = with_standard_errors(
      measurement,
      refine_shapes_in_turn(measurement, fit_gains(measurement, trial.terms, &result.before), {}));
  progress.show("reduce to the controller");
  result.reduced = on_controller(measurement, result.after);
  logs.fit_to_whole({&result.before, &result.reduced, &result.after}, 0.0);
  result.floor_N = NoiseFloor(measurement).of(result.after.terms);
  result.headline = fmt::format("Added {}: held-out error {} before, {} after; noise floor {}.",
                                effect.text.title, newtons(result.before.holdout_rmse_N),
                                newtons(result.after.holdout_rmse_N), newtons(result.floor_N));
  return result;
}

json report_of(const Options& options, const Measurement& measurement, const Addition& addition,
               const Model& model) {
  const double before_N = addition.before.holdout_rmse_N;
  const double after_N = addition.after.holdout_rmse_N;
  json data = report_base(options.command_line, options.log, "add");
  data["verdict"] = {{"kind", "added"}, {"headline", addition.headline}, {"detail", ""}};
  data["figures"] = figures_json(addition.before, addition.floor_N);
  data["figures"]["after_rmse_N"] = number_json(after_N);
  data["figures"]["holdout_interval_N"] = interval_json(addition.before);
  data["figures"]["after_interval_N"] = interval_json(addition.after);
  data["figures"]["after_relative_error"] = number_json(addition.after.relative_error);
  data["baseline_effects"] = ids_of(addition.before.terms);
  data["steps"] = {{{"added", "baseline"}, {"holdout_rmse_N", number_json(before_N)}},
                   {{"added", addition.effect}, {"holdout_rmse_N", number_json(after_N)}}};
  data["parameters"] = parameters_json(addition.after.terms);
  const ForceRows rows_after = rows_of(addition.after);
  add_pictures(data, measurement, rows_of(addition.before), &rows_after);
  add_logs(data, log_results(measurement, addition.after));
  add_history(data, model);
  return data;
}

}  // namespace

void run_add(const Options& options) {
  const EffectDescription& effect = effect_of(options);
  Outputs outputs;
  spare_logs(options, outputs);
  outputs.spare(options.model);
  outputs.claim(options.out);
  outputs.claim(options.report);
  outputs.claim(options.json);
  const Model old = model_to_extend(options, effect);
  Progress progress;
  std::vector<std::string> ids = ids_of(old.terms);
  ids.push_back(effect.id());
  Addition addition;
  LogSearch logs(log_request(options), progress);
  do {
    check_combination(logs.measurement(), ids);
    check_enough(options.log, logs.measurement(), ids);
    addition = added(logs, old, effect, progress);
  } while (logs.extend());
  const Measurement& measurement = logs.measurement();
  Model model = model_of(options.log, measurement, addition.after, addition.reduced, addition.floor_N);
  model.history = old.history;
  model.history.push_back(change_of(options.log, {effect.id()}, addition.before.holdout_rmse_N,
                                    addition.after.holdout_rmse_N, addition.floor_N));

  std::string text = addition.headline + "\n";
  if (addition.after.holdout_rmse_N > (1.0 - kLeastReduction) * addition.before.holdout_rmse_N) {
    text += "It does not earn its parameters: less than 3 % on data that the fit has not seen.\n";
  }
  text += excerpt_line(measurement, "shapes fitted") + repair_lines(measurement) +
          log_table(log_results(measurement, addition.after));
  text += parameter_table(addition.after.terms);
  text += model_lines(options.out, model);

  json result = quality_json(measurement, addition.after, addition.floor_N);
  result["log"] = options.log;
  result["model"] = options.out;
  result["added"] = effect.id();
  result["hash"] = hash_text(model);
  if (!model.target_user_effects.empty()) result["user_effects"] = user_effects_json(model);
  result["history"] = history_json(model);
  result["before"] = {{"train_rmse_N", number_json(addition.before.train_rmse_N)},
                      {"holdout_rmse_N", number_json(addition.before.holdout_rmse_N)},
                      {"relative_error", number_json(addition.before.relative_error)}};
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(report_of(options, measurement, addition, model)));
  }
  outputs.set(options.out, to_toml(model));
  outputs.set(options.json, json_text(result));
  progress.finish();
  outputs.commit(text);
}

}  // namespace slipstack::workbench
