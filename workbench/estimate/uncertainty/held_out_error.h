// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// Sets the errors of a fitted model on data that its parameters have not seen: `holdout_rmse_N` and
/// `block_squared_error` by blocked cross-validation (each fold predicted by a fit to the others; Stone
/// 1974), and `forward_rmse_N`, the last third of each log predicted by a fit to the first two thirds
/// (Bergmeir and Benitez 2012): blocks from all over a log do not show what drifts;
/// `forward_within_travel_N` is the same without the rows where the axis is beyond the travel of the first
/// two thirds (zero where no row is left); `last_third_holdout_rmse_N` is what of the held-out error the last
/// third has. In each of these fits gains and searched shapes move together, damped, from the solution of all
/// data to that of the training data, and the error is that of the force itself, as `compare` computes it,
/// not of its linearisation. The choice of the effects is not repeated, nor that of a pitch. Cost:
/// tangent_of() and, unless the force is linear in all unknowns, about two evaluations of the model for each
/// of the six fits.
void judge_on_unseen_data(const Measurement& measurement, FittedModel& fitted);

/// The weighted error of those blocks that are marked, from the sums of each block [N]; zero where these have
/// no rows.
double rmse_of_blocks(const std::vector<double>& squared_error, const std::vector<double>& weight,
                      const std::vector<bool>& blocks);

/// Marks those of a log's contiguous blocks that its `forward` error predicts: the last third.
void mark_last_third(int first_block, int block_count, std::vector<bool>& blocks);

}  // namespace slipstack::workbench
