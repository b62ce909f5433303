// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/diagnose/diagnose.h"
#include "workbench/diagnose/evidence/naming_rule.h"

namespace slipstack::workbench {

/// Lists the pairs of effects that this log cannot tell apart (is_tie()), and states each at both candidates.
/// Of an effect that is named: with every other in its place in the explanation, which has to be plausible
/// there. Where none is named: of those that reach most of the best reduction of the error alone, if the log
/// supports one of the two. Cost: of several named effects that of another exchange_effects(), else a fit of
/// the gains for every candidate that leaves nearly as little.
void list_ties(const SelectionContext& context, Diagnosis& diagnosis);

/// "cannot tell A from B or C": the words for a tie, behind "this log".
std::string tie_text(const std::string& effect, const std::vector<std::string>& others);

/// The same with the angle between the forces of the pair [degrees].
std::string tie_text(const std::string& effect, const std::string& other, double angle_deg);

}  // namespace slipstack::workbench
