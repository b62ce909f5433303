// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "workbench/analysis/add_effect.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/cli/commands.h"
#include "workbench/cli/inputs.h"
#include "workbench/model/effects/effect_registry.h"
#include "workbench/model/effects/user_effect.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"

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
  LogSearch logs(log_request(options), progress);
  AdditionResult result = add_effect(logs, options.log, old, effect, progress);
  result.command_line = options.command_line;
  result.model_path = options.out;
  const Measurement& measurement = logs.measurement();
  if (!options.report.empty()) {
    outputs.set(options.report, render_report(addition_page(measurement, result)));
  }
  outputs.set(options.out, to_toml(result.model));
  outputs.set(options.json, json_text(addition_json(measurement, result)));
  progress.finish();
  outputs.commit(addition_text(measurement, result));
}

}  // namespace slipstack::workbench
