// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "workbench/base/text.h"
#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/loop/comparison/comparison.h"
#include "workbench/loop/run_loop.h"

namespace slipstack::workbench {

void run_comparison(const ComparisonRequest& request) {
  if (request.setup != "pick_and_place" && request.setup != "random")
    throw UsageError(
        fmt::format("--setup: {} is neither pick_and_place nor random", in_quotes(request.setup)));
  if (request.seed < 0) throw UsageError("--seed: must not be negative");
  if (request.seeds < 1 || request.seeds > 1000) throw UsageError("--seeds: must be between 1 and 1000");
  Outputs outputs;
  outputs.claim(request.json);
  Progress progress;
  const sim::Setup setup = request.setup == "random" ? sim::Setup::kRandom : sim::Setup::kPickAndPlace;
  const Comparison comparison =
      compare(setup, static_cast<std::uint64_t>(request.seed), static_cast<std::size_t>(request.seeds),
              Field::kAll, {.robustness = !request.brief},
              [&](const std::string& stage, double fraction) { progress.show(stage, fraction); });
  if (!request.json.empty()) outputs.set(request.json, comparison_json(comparison).dump(2) + "\n");
  progress.finish();
  outputs.commit(comparison_text(comparison));
}

}  // namespace slipstack::workbench
