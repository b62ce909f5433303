// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

struct ConfidenceInterval {
  double low = 0.0;
  double high = 0.0;
};

/// The central 95 % of sqrt(sum of squared errors / sum of weights) when the blocks are drawn with
/// replacement (block bootstrap; Kuensch 1989): the range for another record of as many such blocks. One
/// entry per block. The seed is fixed, so the same blocks give the same interval. Cost: 1000 x blocks.
ConfidenceInterval block_bootstrap(const std::vector<double>& squared_errors,
                                   const std::vector<double>& weights);

/// The confidence interval of a model's held-out error.
ConfidenceInterval holdout_interval(const FittedModel& fitted);

}  // namespace slipstack::workbench
