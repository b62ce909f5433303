// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/loop/axis_options.h"
#include "workbench/loop/comparison/comparison.h"
#include "workbench/loop/run_loop.h"

namespace slipstack::workbench {

void run_comparison(const ComparisonRequest& request) {
  const sim::Setup setup = setup_named(request.setup);
  const std::uint64_t seed = seed_of(request.seed);
  if (request.seeds < 1 || request.seeds > 1000) throw UsageError("--seeds: must be between 1 and 1000");
  Outputs outputs;
  outputs.claim(request.json);
  Progress progress;
  const Comparison comparison = compare(
      setup, seed, static_cast<std::size_t>(request.seeds), Field::kAll, {.robustness = !request.brief},
      [&](const std::string& stage, double fraction) { progress.show(stage, fraction); });
  if (!request.json.empty()) outputs.set(request.json, comparison_json(comparison).dump(2) + "\n");
  progress.finish();
  outputs.commit(comparison_text(comparison));
}

}  // namespace slipstack::workbench
