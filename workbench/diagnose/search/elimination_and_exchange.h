// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/diagnose/evidence/naming_rule.h"
#include "workbench/estimate/nonlinear/trial.h"

namespace slipstack::workbench {

/// Drops effects that are no step beside the others. The effect added last is tested too, because the
/// effects that it was added to may have changed since. Returns those that were dropped because refined
/// shapes have made them implausible (modes and lags only).
std::vector<std::string> drop_superfluous(const SelectionContext& context, Explanation& explanation);

/// Drops Coulomb friction that is what the hysteresis leaves of a virgin curve of another form: what stood
/// beside it may have been taken from the model since.
void drop_coulomb_of_hysteresis(const SelectionContext& context, Explanation& explanation);

/// Whether the log determines nothing of a term of a model with standard errors: its one gain is within two
/// standard errors of zero, or the times of a delay are, each and together; or each of several gains is, and
/// a shape is anything: its standard error is above its value, or its search ended at a bound (but the
/// frequency of a mode above the band, for which has_implausible_mode() asks more; of a memory's time and
/// distance both). Of several gains each may be within two where together they are not. What a map is, no
/// single gain tells.
bool is_undetermined(const Measurement& measurement, const FittedModel& model, const Term& term);

/// Drops effects of which the log determines nothing: whose gain differs from zero by less than two standard
/// errors beside the others (two that cancel each other lower the error together, and the log does not say
/// how large they are); whose gains all do, with a shape that may be anything; a difference between the
/// directions that is none in steady motion. Returns them. Cost: the standard errors of the model, once more
/// for each that is dropped.
std::vector<std::string> drop_undetermined(const SelectionContext& context, Explanation& explanation);

/// Replaces an effect by another that has the better criterion beside the other effects: what was best while
/// effects were missing need not be best beside them. `alone`: the trials of all effects on the baseline,
/// of which those of `refused` are left out.
void exchange_effects(const SelectionContext& context, const std::vector<Trial>& alone,
                      const std::vector<std::string>& refused, Explanation& explanation);

/// Exchanges an effect for its special case and a delay where both together are better: a delay makes
/// friction follow the velocity late, as a frictional lag does, and a payload swing, as a mode does. Alone
/// neither is better, so that no exchange of one effect for another finds them. `alone` as above.
void exchange_for_delayed_special_cases(const SelectionContext& context, const std::vector<Trial>& alone,
                                        const std::vector<std::string>& refused, Explanation& explanation);

}  // namespace slipstack::workbench
