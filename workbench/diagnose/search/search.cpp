// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/search/search.h"

#include <algorithm>
#include <utility>

#include "workbench/diagnose/evidence/plausibility.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/diagnose/search/exchange.h"
#include "workbench/diagnose/search/mass_and_mode.h"

namespace slipstack::workbench {
namespace {

/// Effects that are added at most. Chosen.
constexpr std::size_t kMostSteps = 5;
/// Explanations that are kept from level to level. Chosen on the blind bench.
constexpr std::size_t kBeam = 3;

/// Adds every further effect to every explanation of the beam: all to first order, the best fitted in full,
/// of which the plausible ones are returned, the best first. The trials of the first level are stored, since
/// all of them are reported as candidates.
std::vector<Explanation> grow(const DiagnoseOptions& options, const std::vector<Explanation>& beam,
                              bool first, Found& found) {
  const SelectionContext& context = found.context;
  std::vector<Attempt> attempts =
      try_effects(context.measurement, options, beam, first ? nullptr : &found.alone);
  if (first) {
    found.alone.reserve(attempts.size());
    for (const Attempt& attempt : attempts) found.alone.push_back(attempt.trial);
  }
  std::vector<Explanation> grown = fit_best(context, std::move(attempts), 2 * kBeam);
  if (first) found.first_level = grown;
  std::erase_if(grown, [&](const Explanation& one) {
    return is_implausible(context.measurement, context.floor, context.baseline, one.model);
  });
  sort_by_criterion(context, grown);
  return grown;
}

/// An explanation with its shapes refined before further effects are tried. A delay also gets its low pass:
/// the error of a low pass that is modelled as a delay resembles a mode.
Explanation refined(const SelectionContext& context, Explanation explanation) {
  FittedModel model = refine_shapes_in_turn(context.measurement, std::move(explanation.model), {20});
  if (has_role(model.terms, Role::measurement_delay))
    model = refine_delay(context.measurement, std::move(model));
  return {std::move(model), std::move(explanation.added)};
}

/// Effects are added one after the other as long as the criterion falls.
void add_effects(const DiagnoseOptions& options, Found& found) {
  const SelectionContext& context = found.context;
  std::vector<Explanation> beam{found.best};
  for (std::size_t level = 0; level < kMostSteps; ++level) {
    std::vector<Explanation> next = grow(options, beam, level == 0, found);
    if (next.empty()) break;
    if (is_step(context, found.best, next.front())) {
      next.front() = refined(context, std::move(next.front()));
      found.best = next.front();
      if (at_floor(context, found.best.model)) break;
    } else if (level > 0) {
      break;  // a pair may be a step where its first effect is none
    }
    if (next.size() > kBeam) next.resize(kBeam);
    beam = std::move(next);
  }
}

}  // namespace

Found search(const Measurement& measurement, const DiagnoseOptions& options, const FittedModel& baseline,
             const NoiseFloor& floor) {
  const Criterion criterion(measurement, baseline.terms, choices_of(measurement, options, baseline.terms));
  Found found{{}, {measurement, baseline, floor, criterion}, {}, {}};
  found.best.model = baseline;
  add_effects(options, found);
  if (found.best.added.empty()) return found;
  drop_superfluous(found.context, found.best);
  exchange_effects(found.context, found.alone, found.best);
  name_mass_beside_mode(found.context, found.best);
  FittedModel model = refine_nominal_shapes(measurement, std::move(found.best.model));
  found.best.model = refine_all_shapes(measurement, std::move(model));
  // With refined shapes, the first effect may explain what another was added for.
  if (found.best.added.size() > 1) drop_superfluous(found.context, found.best);
  return found;
}

}  // namespace slipstack::workbench
