// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/experiment.h"

#include <fmt/format.h>

#include <stdexcept>

#include "sim_host/experiments/setup.h"
#include "workbench/base/text.h"
#include "workbench/log/log.h"
#include "workbench/report/json_values.h"
#include "workbench/report/page/html.h"

namespace slipstack::workbench {
CLI::Option* add_word(CLI::App& command, const std::string& name, std::string& value, const std::string& kind,
                      const std::string& description) {
  const auto not_empty = [](const std::string& text) {
    return text.empty() ? std::string("must not be empty") : std::string();
  };
  return command.add_option(name, value, description)->check(not_empty)->type_name(kind);
}

void add_experiment_outputs(CLI::App& command, ExperimentOutputs& outputs) {
  add_word(command, "--report", outputs.report, "FILE", "write a report: one HTML page that opens offline");
  add_word(command, "--json", outputs.json, "FILE", "write the result for machines; '-': standard output");
}

void said_of(const std::string& where, const std::function<void()>& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("{}: {}", printable(where), error.what()));
  }
}

void deliver(const std::string& command_line, const ExperimentOutputs& outputs,
             const std::vector<std::string>& inputs, const std::function<ExperimentResult(Progress&)>& work) {
  Outputs files;
  for (const std::string& input : inputs) files.protect_input(input);
  files.claim(outputs.report);
  files.claim(outputs.json);
  files.claim(outputs.out);
  Progress progress;
  ExperimentResult result;
  try {
    result = work(progress);
  } catch (const sim::SetupError& error) {
    throw UsageError(error.what());
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  files.set(outputs.json, json_text(result_json(result)));
  files.set(outputs.out, result.file);
  if (!outputs.report.empty()) {
    files.set(outputs.report, render_report(result_report(result, command_line)));
  }
  progress.finish();
  files.commit(result_text(result));
}

}  // namespace slipstack::workbench
