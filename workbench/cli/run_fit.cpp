// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "workbench/base/text.h"
#include "workbench/cli/commands.h"
#include "workbench/cli/inputs.h"
#include "workbench/estimate/nonlinear/checks.h"
#include "workbench/estimate/nonlinear/robust.h"
#include "workbench/estimate/uncertainty/noise_floor.h"
#include "workbench/estimate/uncertainty/standard_errors.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/report/html.h"
#include "workbench/report/results.h"
#include "workbench/report/text_tables.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

json report_of(const Options& options, const Measurement& measurement, const FittedModel& fitted,
               double floor_N) {
  json data = report_base(options.command_line, options.log, "fit");
  data["verdict"] = {{"kind", "fit"},
                     {"headline", fmt::format("Fitted: {} held-out error, noise floor {}.",
                                              newtons(fitted.holdout_rmse_N), newtons(floor_N))},
                     {"detail", ""}};
  data["figures"] = figures_json(fitted, floor_N);
  data["baseline_effects"] = ids_of(fitted.terms);
  data["parameters"] = parameters_json(fitted.terms);
  add_pictures(data, measurement, rows_of(fitted), nullptr);
  return data;
}

std::string outlier_line(const RobustFit& robust) {
  if (robust.outliers == 0) return "";
  return fmt::format(
      "outliers   {} instants beyond five robust standard deviations pull no more than at five (Huber), the "
      "first at {:.3f} s\n",
      robust.outliers, robust.first_s);
}

}  // namespace

void run_fit(const Options& options) {
  const std::vector<const EffectDescription*> own = declare_effects(options.user_effects);
  std::vector<std::string> ids = parse_effects(options.effects);
  for (const EffectDescription* effect : own) {
    if (std::find(ids.begin(), ids.end(), effect->id()) == ids.end()) ids.push_back(effect->id());
  }
  Outputs outputs;
  spare_logs(options, outputs);
  outputs.claim(options.model);
  outputs.claim(options.report);
  outputs.claim(options.json);
  Progress progress;
  RobustFit robust;
  FittedModel fitted;
  FittedModel reduced;
  LogSearch logs(log_request(options), progress);
  do {
    Measurement& measured = logs.measurement();
    check_combination(measured, ids);
    check_enough(options.log, measured, ids);
    progress.show("fit");
    robust = fit_robustly(measured, refine_nominal_shapes(measured, fit_effects(measured, ids, {})));
    fitted = with_standard_errors(measured, robust.model);
    progress.show("reduce to the controller");
    reduced = on_controller(measured, fitted);
    logs.fit_to_whole({&fitted, &reduced}, robust.limit_N);
  } while (logs.extend());
  const Measurement& measurement = logs.measurement();
  const double floor_N = NoiseFloor(measurement).of(fitted.terms);
  Model model = model_of(options.log, measurement, fitted, reduced, floor_N);
  model.history = {change_of(options.log, ids, 0.0, fitted.holdout_rmse_N, floor_N)};

  std::string text =
      fmt::format("log        {}\neffects    {}\n", printable(options.log), fmt::join(ids, ", "));
  text += fmt::format("error      {} held out ({}), {} in sample, {} of the force; noise floor {}\n",
                      newtons(fitted.holdout_rmse_N), interval_text(fitted), newtons(fitted.train_rmse_N),
                      share(fitted.relative_error), newtons(floor_N));
  text += noise_line(measurement) + excerpt_line(measurement, "shapes fitted") + repair_lines(measurement) +
          outlier_line(robust);
  text += log_table(log_results(measurement, fitted));
  text += parameter_table(fitted.terms);
  text += model_lines(options.model, model);

  json result = quality_json(measurement, fitted, floor_N);
  result["log"] = options.log;
  result["model"] = options.model;
  result["outliers"] = robust.outliers;
  result["hash"] = hash_text(model);
  if (!model.target_user_effects.empty()) result["user_effects"] = user_effects_json(model);
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(report_of(options, measurement, fitted, floor_N)));
  }
  outputs.set(options.model, to_toml(model));
  outputs.set(options.json, json_text(result));
  progress.finish();
  outputs.commit(text);
}

}  // namespace slipstack::workbench
