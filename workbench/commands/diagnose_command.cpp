// SPDX-License-Identifier: Apache-2.0

#include "workbench/commands/inputs.h"
#include "workbench/diagnose/baseline.h"
#include "workbench/diagnose/diagnose.h"
#include "workbench/model/effect_adapters/effect_registry.h"
#include "workbench/model/model.h"
#include "workbench/report/html/report_page.h"
#include "workbench/report/json_values.h"
#include "workbench/report/results/diagnosis_result.h"

namespace slipstack::workbench {

namespace {

/// --baseline that leaves the choice to the program.
constexpr const char* kAutomatic = "auto";

}  // namespace

CommandResult execute_diagnose(const CommandOptions& options, Outputs& outputs, Progress& progress) {
  DiagnoseOptions wanted;
  wanted.user_effects = declare_effects(options.user_effects);
  spare_logs(options, outputs);
  spare_model(options, outputs);
  outputs.claim(options.report);
  outputs.claim(options.json);
  Model model;
  if (options.model.empty()) {
    if (options.effects != kAutomatic) {
      wanted.baseline = options.effects.empty() ? default_baseline() : parse_effects(options.effects);
    }
  } else {
    model = model_of(options);
    wanted.baseline = ids_of(model.terms);
    wanted.start = model.terms;
  }
  wanted.progress = [&progress](const std::string& stage, double fraction) {
    progress.show(stage, fraction);
  };
  LogSearch logs(log_request(options), progress);
  if (options.effects == kAutomatic) {
    progress.show("choose the baseline");
    wanted.baseline = chosen_baseline(logs.measurement());
  }
  const Diagnosis diagnosis = logs.diagnose(wanted);
  const Measurement& measurement = logs.measurement();

  const DiagnosisRequest request{
      options.command_line, log_names(options), {options.logs, options.model}, options.stepwise};
  const DiagnosisResult result = diagnosis_result(request, measurement, diagnosis);
  if (!options.report.empty()) {
    progress.show("write the report");
    const Model* const start = options.model.empty() ? nullptr : &model;
    outputs.set(options.report,
                render_report(diagnosis_page(request, measurement, diagnosis, result, start)));
  }
  CommandResult given{diagnosis_text(request, measurement, result),
                      published_text(published_json(request, result), "diagnose-1"), ""};
  outputs.set(options.json, given.json);
  return given;
}

}  // namespace slipstack::workbench
