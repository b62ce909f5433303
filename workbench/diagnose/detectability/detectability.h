// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "workbench/diagnose/detectability/separation.h"
#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// What a log could say of an effect if the axis had it.
struct Visibility {
  std::string effect;
  double share = 0.0;    ///< of its force (mean square) that no change of the baseline's parameters imitates
  double least_N = 0.0;  ///< peak of its force from which on it would be named; infinite where share is zero
};

/// How much of `term` this log shows beside `base`: the part of its columns that is orthogonal to the columns
/// of `base` (the squared sine of the canonical angle for one gain; of several, for the gains as fitted or,
/// without any, for the one seen best). `least_N` follows from the reduction of the error that naming asks
/// for. `imitated`: baseline_residual_maker() of `base`, the same for every term. Cost: columns of one
/// effect.
Visibility visibility_of(const Measurement& measurement, const FittedModel& base,
                         const ResidualMaker& residual_maker, const Term& term, double least_reduction);

}  // namespace slipstack::workbench
