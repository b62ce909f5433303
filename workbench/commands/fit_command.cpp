// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "workbench/analysis/fit_model.h"
#include "workbench/commands/inputs.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {
namespace {

/// The effects of --effects, and those that --effect defines.
std::vector<std::string> effects_to_fit(const CommandOptions& options) {
  const std::vector<const EffectDescription*> user_effects = declare_effects(options.user_effects);
  std::vector<std::string> ids = parse_effects(options.effects);
  for (const EffectDescription* effect : user_effects) {
    if (std::find(ids.begin(), ids.end(), effect->id()) == ids.end()) ids.push_back(effect->id());
  }
  return ids;
}

}  // namespace

CommandResult execute_fit(const CommandOptions& options, Outputs& outputs, Progress& progress) {
  const std::vector<std::string> ids = effects_to_fit(options);
  spare_logs(options, outputs);
  outputs.claim(options.model);
  outputs.claim(options.report);
  outputs.claim(options.json);
  LogSearch logs(log_request(options), progress);
  FitResult result = fit_model(
      logs, {log_names(options), ids, options.criterion == "simulation", options.horizon_s}, progress);
  result.command_line = options.command_line;
  result.model_path = options.model;
  const Measurement& measurement = logs.measurement();
  if (!options.report.empty()) outputs.set(options.report, render_report(fit_page(measurement, result)));
  CommandResult given{fit_text(measurement, result), published_text(fit_json(measurement, result), "fit-1"),
                      to_toml(result.model)};
  outputs.set(options.model, given.file);
  outputs.set(options.json, given.json);
  return given;
}

}  // namespace slipstack::workbench
