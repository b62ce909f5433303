// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "workbench/analysis/add_effect.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/commands/inputs.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/effect_adapters/user_effect.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

namespace slipstack::workbench {
namespace {

/// The one effect that --effect names or defines.
const EffectDescription& effect_of(const CommandOptions& options) {
  return is_definition(options.effect) ? declare_effect(options.effect) : effect_named(options.effect);
}

Model model_to_extend(const CommandOptions& options, const EffectDescription& effect) {
  Model model = model_of(options);
  if (contains(model.terms, effect.text.id)) {
    throw UsageError(
        fmt::format("{} already contains {}; add another effect", printable(options.model), effect.id()));
  }
  return model;
}

}  // namespace

CommandResult execute_add(const CommandOptions& options, Outputs& outputs, Progress& progress) {
  const EffectDescription& effect = effect_of(options);
  spare_logs(options, outputs);
  spare_model(options, outputs);
  outputs.claim(options.out);
  outputs.claim(options.report);
  outputs.claim(options.json);
  const Model old = model_to_extend(options, effect);
  LogSearch logs(log_request(options), progress);
  AdditionResult result = add_effect(logs, log_names(options), old, effect, progress);
  result.command_line = options.command_line;
  result.model_path = options.out;
  const Measurement& measurement = logs.measurement();
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(addition_page(measurement, result)));
  }
  CommandResult given{addition_text(measurement, result),
                      published_text(addition_json(measurement, result), "add-1"), to_toml(result.model)};
  outputs.set(options.out, given.file);
  outputs.set(options.json, given.json);
  return given;
}

}  // namespace slipstack::workbench
