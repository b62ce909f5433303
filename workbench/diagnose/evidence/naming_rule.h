// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/diagnose/evidence/criterion.h"

namespace slipstack::workbench {

/// The noise floor is itself uncertain by this factor (docs/theory.md, "Noise floor"), so errors that differ
/// by less are the same multiple of it.
inline constexpr double kUncertainFloor = 1.1;

/// A model that the search has reached: the baseline and the effects that were added.
struct Explanation {
  FittedModel model;
  std::vector<std::string> added;
};

/// By what explanations of one measurement are compared.
struct SelectionContext {
  const Measurement& measurement;
  const FittedModel& baseline;
  Criterion criterion;
};

/// Whether the first explanation has the better criterion. Where they differ in one effect only, of which one
/// is a special case of the other (EffectTraits::special_case), the general effect must also lower the
/// held-out error by the share that is worth a name; and a cause outside the catalogue is not better than an
/// effect against which the log does not support it, or that leaves less than half of its error on unseen
/// data (mean square).
bool is_better(const SelectionContext& context, const Explanation& one, const Explanation& other);

/// Whether the log names the effect that `one` has and `other` has not, in its place: it supports the one
/// against the other (is_supported()), and the held-out error falls as it does with an effect that is named
/// (is_significant()). A general effect imitates its special case, which therefore leaves no lower error:
/// that is named where the general one does not lower the error by more than the standard error of that.
bool is_named_over(const SelectionContext& context, const Explanation& one, const Explanation& other);

/// Whether the log cannot tell two effects apart, by explanations that differ only in them: it names neither
/// over the other. The one definition of a tie.
bool is_tie(const SelectionContext& context, const Explanation& one, const Explanation& other);

/// Puts the explanation that is better than all others first, then the others by their criterion.
void sort_by_criterion(const SelectionContext& context, std::vector<Explanation>& all);

/// Whether the error is so far above the noise floor that there is something to explain.
bool is_above_floor(const Measurement& measurement, const FittedModel& model);

/// Whether the log supports the step from `before` to `after` (criterion.h), and the held-out error, which is
/// above the noise floor, falls by the share that is worth a name (kLeastReduction).
bool is_improvement(const SelectionContext& context, const Explanation& before, const Explanation& after);

/// Whether that step is made: it is an improvement, and not too small for a name (is_too_small()).
bool is_step(const SelectionContext& context, const Explanation& before, const Explanation& after);

}  // namespace slipstack::workbench
