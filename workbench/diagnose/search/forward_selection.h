// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/evidence/naming_rule.h"
#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// An explanation with one further effect, its gains to first order.
struct Attempt {
  const Explanation* from;
  const EffectDescription* effect;
  Trial trial;
};

/// The work on the shapes of an effect that has been found before, where others have changed beside it. On 45
/// training logs (docs/theory.md) 20 evaluations everywhere name the same effects as 6 for a first look, 20
/// for the best of them and 15 or 20 afterwards did.
inline constexpr SearchEffort kRefinement{20, kFirstLook.tolerance};

/// Without a search: the shapes are those from which it would begin.
inline constexpr SearchEffort kUnmoved{0, kRefinement.tolerance};

/// Tries every candidate on top of every explanation of `beam`; the lowest error first. `alone`: the trials
/// on the baseline, whose shapes are the starting values, searched for the `searched` attempts that leave
/// least with them; null on the first level, which searches all of them globally. The attempts point into
/// `beam`.
std::vector<Attempt> try_effects(const Measurement& measurement, const DiagnoseOptions& options,
                                 const std::vector<Explanation>& beam, const std::vector<Trial>* alone,
                                 std::size_t searched);

/// Fits in full the best `most` of the promising attempts, each set of effects once.
std::vector<Explanation> fit_best(const SelectionContext& context, std::vector<Attempt> attempts,
                                  std::size_t most);

/// Tries an effect, or a cause outside the catalogue, on top of a model, from starting points of its own.
Trial try_anew(const Measurement& measurement, const FittedModel& from, const EffectDescription& effect);
/// The same without a search: with the shapes of its best starting point.
Trial try_at_best_start(const Measurement& measurement, const FittedModel& from,
                        const EffectDescription& effect);
/// A trial on top of `from` with its shapes searched, from those that it has.
Trial with_shapes_searched(const Measurement& measurement, const FittedModel& from, Trial trial,
                           const SearchEffort& effort);

/// The number of effects that a search with these options can add to the baseline.
std::size_t choices_of(const Measurement& measurement, const DiagnoseOptions& options, const Terms& baseline);

/// The trial of an effect; null where there is none.
const Trial* find_trial(const std::vector<Trial>& trials, std::string_view id);

}  // namespace slipstack::workbench
