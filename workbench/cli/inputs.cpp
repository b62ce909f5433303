// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/inputs.h"

#include "workbench/model/effects/effect_registry.h"

namespace slipstack::workbench {

void spare_logs(const Options& options, Outputs& outputs) {
  for (const std::string& log : options.logs) outputs.protect_input(log);
}

LogRequest log_request(const Options& options) {
  LogRequest request{options.group, options.logs, {}};
  request.conditioning.force_noise_N = options.noise_N;
  if (options.per_log == "none") {
    request.conditioning.per_log.clear();
  } else if (!options.per_log.empty()) {
    request.conditioning.per_log = parse_effects(options.per_log);
  }
  return request;
}

}  // namespace slipstack::workbench
