// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "workbench/diagnose/detectability/separation.h"
#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// How well a log would show an effect if the axis had it.
struct Visibility {
  std::string effect;
  double share =
      0.0;  ///< of its force (mean square), the part that no change of the baseline's parameters imitates
  double least_N =
      0.0;  ///< peak of the force from which on the effect would be named; infinite where share is 0
  double least_rms_N = 0.0;  ///< the same as root mean square over the log
};

/// The part of the columns of `term` that is orthogonal to the columns of `base` (for one gain the squared
/// sine of the canonical angle; for several gains with the gains as fitted, or, where none is fitted, with
/// the gain whose column has the largest orthogonal part). `least_N` follows from `least_reduction`, the
/// reduction of the error from which on an effect is named, and from what is too small (least_named_N()).
/// `residual_maker`: baseline_residual_maker() of `base`, the same for every term. Cost: the columns of one
/// effect.
Visibility visibility_of(const Measurement& measurement, const FittedModel& base,
                         const ResidualMaker& residual_maker, const Term& term, double least_reduction);

/// From which value on gain `gain` of the term, alone, would be named; of a delay, which has no gain, the
/// delay [s]. By the error and by what is too small, as visibility_of(). Infinite
/// where the baseline imitates all of it. Cost: the columns of one effect.
double detection_limit(const Measurement& measurement, const FittedModel& base,
                       const ResidualMaker& residual_maker, const Term& term, std::size_t gain = 0);

}  // namespace slipstack::workbench
