// SPDX-License-Identifier: Apache-2.0
#include "workbench/commands/inputs.h"

#include "workbench/base/text.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {

void spare_logs(const CommandOptions& options, Outputs& outputs) {
  for (const std::string& log : options.logs) {
    if (!options.in_memory.contains(log)) outputs.protect_input(log);
  }
}

void spare_model(const CommandOptions& options, Outputs& outputs) {
  if (!options.model.empty() && !options.model_content) outputs.protect_input(options.model);
}

LogRequest log_request(const CommandOptions& options) {
  LogRequest request{options.group, options.logs, {}, options.in_memory};
  request.conditioning.force_noise_N = options.noise_N;
  if (options.per_log == "none") {
    request.conditioning.per_log.clear();
  } else if (!options.per_log.empty()) {
    request.conditioning.per_log = parse_effects(options.per_log);
  }
  return request;
}

std::string log_names(const CommandOptions& options) {
  return joined(options.logs);
}

Model model_of(const CommandOptions& options) {
  return read_model(options.model, options.model_content);
}

}  // namespace slipstack::workbench
