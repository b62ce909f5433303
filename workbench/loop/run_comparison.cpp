// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "workbench/console/output.h"
#include "workbench/console/progress.h"
#include "workbench/loop/axis_options.h"
#include "workbench/loop/comparison/comparison.h"
#include "workbench/loop/run_loop.h"

namespace slipstack::workbench {

void run_comparison(const ComparisonRequest& request) {
  if (request.seeds < 1 || request.seeds > 1000) throw UsageError("--seeds: must be between 1 and 1000");
  if (request.encoder_nm != 0.0 && !(request.encoder_nm >= 1.0 && request.encoder_nm <= 1e5))
    throw UsageError("--encoder: must be between 1 and 100000 nm");
  check_strength(request.strength);
  effects_by_seed(request.effects, 0);  // names that are none are refused before anything is measured
  const bool with_effects = request.effects != "none";
  const ComparisonTask task{.setup = setup_named(request.setup),
                            .first_seed = seed_of(request.seed),
                            .seeds = static_cast<std::size_t>(request.seeds),
                            .encoder_resolution_m = 1e-9 * request.encoder_nm,
                            .effects = request.effects,
                            .strength = request.strength,
                            .field = with_effects ? Field::kWithEffects : Field::kAll,
                            .extent = {.robustness = !request.brief && !with_effects}};
  Outputs outputs;
  outputs.claim(request.json);
  ComparisonFile kept;
  if (!request.keep.empty()) {
    kept = ComparisonFile(
        request.keep,
        "slipstack " SLIPSTACK_VERSION ", " + request.setup + (request.brief ? ", brief" : ", whole") +
            (request.encoder_nm > 0.0 ? fmt::format(", encoder {} nm", request.encoder_nm) : "") +
            (with_effects ? fmt::format(", effects {}, strength {}", request.effects, request.strength)
                          : ""));
  }
  Progress progress;
  const Comparison comparison =
      compare(task, kept, [&](const std::string& stage, double fraction) { progress.show(stage, fraction); });
  if (!request.json.empty()) outputs.set(request.json, comparison_json(comparison).dump(2) + "\n");
  progress.finish();
  outputs.commit(comparison_text(comparison));
}

}  // namespace slipstack::workbench
