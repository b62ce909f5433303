// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "workbench/base/text.h"
#include "workbench/cli/commands.h"
#include "workbench/cli/inputs.h"
#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/estimate/nonlinear/checks.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/estimate/uncertainty/unseen_error.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/model/effects/user_effect.h"
#include "workbench/report/addition_result.h"
#include "workbench/report/fitted_model_file.h"
#include "workbench/report/json_values.h"
#include "workbench/report/model_notes.h"
#include "workbench/report/page/html.h"

namespace slipstack::workbench {
namespace {

/// The one effect that --effect names or defines.
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
  FittedModel before;
  FittedModel after;
  double criterion_difference = 0.0;
  FittedModel reduced;  ///< `after` as the controller runs it
};

/// Fits the old model and the model with the effect to what is searched, then their gains to the whole logs.
Addition add_effect(LogSearch& logs, const Model& old, const EffectDescription& effect, Progress& progress) {
  const Measurement& measurement = logs.measurement();
  Addition addition;
  progress.show("fit the model as it is");
  addition.before = fit_gains(measurement, terms_on(measurement, old.terms));
  progress.show("add the effect");
  const Trial trial = try_effect(measurement, addition.before, effect, {});
  addition.after = with_standard_errors(
      measurement,
      refine_shapes_in_turn(measurement, fit_gains(measurement, trial.terms, &addition.before), {}));
  const Criterion criterion(measurement, addition.before.terms, 1);
  addition.criterion_difference = criterion.difference(addition.after, addition.before);
  progress.show("judge on unseen data");
  judge_on_unseen_data(measurement, addition.before);
  judge_on_unseen_data(measurement, addition.after);
  progress.show("reduce to the controller");
  addition.reduced = on_controller(measurement, addition.after);
  logs.fit_to_whole({&addition.before, &addition.reduced, &addition.after}, 0.0);
  return addition;
}

}  // namespace

void run_add(const Options& options) {
  const EffectDescription& effect = effect_of(options);
  Outputs outputs;
  spare_logs(options, outputs);
  outputs.protect_input(options.model);
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
    addition = add_effect(logs, old, effect, progress);
  } while (logs.extend());
  const Measurement& measurement = logs.measurement();

  AdditionResult result;
  result.command_line = options.command_line;
  result.log = options.log;
  result.model_path = options.out;
  result.effect = effect.id();
  result.title = effect.text.title;
  result.criterion_difference = addition.criterion_difference;
  result.before = std::move(addition.before);
  result.after = std::move(addition.after);
  result.noise_floor_N = measurement.noise_floor_N();
  result.logs = log_results(measurement, result.after);
  result.model = model_of(options.log, measurement, result.after, addition.reduced, result.noise_floor_N);
  result.model.history = old.history;
  result.model.history.push_back(change_of(options.log, {effect.id()}, result.before.holdout_rmse_N,
                                           result.after.holdout_rmse_N, result.noise_floor_N));
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(addition_page(measurement, result)));
  }
  outputs.set(options.out, to_toml(result.model));
  outputs.set(options.json, json_text(addition_json(measurement, result)));
  progress.finish();
  outputs.commit(addition_text(measurement, result));
}

}  // namespace slipstack::workbench
