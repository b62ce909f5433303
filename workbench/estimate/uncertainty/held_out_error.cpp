// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/uncertainty/held_out_error.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "workbench/base/parallel.h"
#include "workbench/base/statistics.h"
#include "workbench/estimate/linear/tall_product.h"
#include "workbench/estimate/nonlinear/damped_step.h"
#include "workbench/estimate/nonlinear/tangent.h"

namespace slipstack::workbench {
namespace {

/// Steps of a fit to the training data, which starts at the solution of all data. Columns stay those of that
/// solution, so the steps converge linearly; later ones change the error by less than its last digit printed.
constexpr int kMostSteps = 6;
constexpr int kMostHalvings = 6;
/// Relative decrease of the training error that ends the steps, where the tangent promises no more or a step
/// brought no more.
constexpr double kConverged = 1e-4;

/// Fits of a model to parts of the data.
class PartialFits {
 public:
  PartialFits(const Measurement& measurement, const FittedModel& fitted)
      : measurement_(measurement),
        fitted_(fitted),
        tangent_(tangent_of(measurement, fitted)),
        linear_(tangent_.shapes.empty() && !any_multiplies(fitted.terms)),
        equations_(measurement, tangent_.columns, fitted.linearisation->target()) {
    hold_low_pass(fitted, tangent_);
    hold_pitches();
    bound_states_ = fitted.solution.bound_states;
    bound_states_.resize(static_cast<std::size_t>(tangent_.columns.cols()), BoundState::free);
    solution_ = Eigen::VectorXd::Zero(tangent_.columns.cols());
    solution_.head(tangent_.gains) = gains_of(fitted.terms);
  }

  /// Residual at all rows after a fit that has not seen these blocks.
  Eigen::VectorXd residual_without(const std::vector<bool>& blocks) const {
    Eigen::VectorXd value = solution_;
    Eigen::VectorXd residual_N = fitted_.linearisation->residual_N();
    const Eigen::VectorXd weights = training_weights(blocks);
    double cost = cost_of(weights, residual_N, value);
    for (int step = 0; step < kMostSteps; ++step) {
      const Eigen::VectorXd wanted = solve(blocks, step, residual_N, value);
      Eigen::VectorXd promised_N = residual_N - tall_combination(tangent_.columns, wanted - value);
      if (linear_) return promised_N;
      if (cost_of(weights, promised_N, wanted) > (1.0 - kConverged) * cost) break;
      const double before = cost;
      step_towards(wanted, weights, value, residual_N, cost);
      if (cost > (1.0 - kConverged) * before) break;
    }
    return residual_N;
  }

 private:
  /// Far from where positions are zero, a change of the pitch turns the phase by much more than the tangent
  /// is good for, so that the error would depend on where zero is. Pitches stay those of all data.
  void hold_pitches() {
    for (std::size_t i = 0; i < tangent_.shapes.size(); ++i) {
      const FreeShape& shape = tangent_.shapes[i];
      if (fitted_.terms[shape.term].effect->shapes[shape.shape].kind != ShapeKind::pitch) continue;
      const Eigen::Index column = tangent_.column_of(i);
      tangent_.constraints.lower(column) = tangent_.constraints.upper(column) = 0.0;
    }
  }

  Eigen::VectorXd training_weights(const std::vector<bool>& blocks) const {
    Eigen::VectorXd weights = measurement_.fit_weights();
    const std::vector<int>& block_of = measurement_.row_blocks();
    for (Eigen::Index row = 0; row < weights.size(); ++row) {
      if (blocks[static_cast<std::size_t>(block_of[static_cast<std::size_t>(row)])]) weights(row) = 0.0;
    }
    return weights;
  }

  double cost_of(const Eigen::VectorXd& weights, const Eigen::VectorXd& residual_N,
                 const Eigen::VectorXd& value) const {
    return weights.dot(residual_N.cwiseAbs2()) + value.dot(tangent_.constraints.penalty * value);
  }

  Eigen::VectorXd solve(const std::vector<bool>& blocks, int step, const Eigen::VectorXd& residual_N,
                        const Eigen::VectorXd& value) const {
    if (step == 0) return equations_.fit_without(blocks, tangent_.constraints, bound_states_).value;
    const Eigen::VectorXd target = residual_N + tall_combination(tangent_.columns, value);
    return equations_.with_target(measurement_, tangent_.columns, target)
        .fit_without(blocks, tangent_.constraints, bound_states_)
        .value;
  }

  /// Moves `value` towards `wanted` as far as the training error falls.
  void step_towards(const Eigen::VectorXd& wanted, const Eigen::VectorXd& weights, Eigen::VectorXd& value,
                    Eigen::VectorXd& residual_N, double& cost) const {
    take_damped_step(kMostHalvings, [&](double share) {
      Eigen::VectorXd there = value + share * (wanted - value);
      Eigen::VectorXd residual_there_N = residual_at(there);
      const double cost_there = cost_of(weights, residual_there_N, there);
      if (cost_there >= cost) return false;
      value = std::move(there);
      residual_N = std::move(residual_there_N);
      cost = cost_there;
      return true;
    });
  }

  Eigen::VectorXd residual_at(const Eigen::VectorXd& value) const {
    Terms terms = fitted_.terms;
    take_gains(terms, value.head(tangent_.gains));
    for (std::size_t i = 0; i < tangent_.shapes.size(); ++i) {
      const FreeShape& shape = tangent_.shapes[i];
      double& moved = terms[shape.term].shapes[shape.shape];
      moved = std::clamp(moved + value(tangent_.column_of(i)), shape.lower, shape.upper);
    }
    return fitted_.linearisation->residual_at(terms);
  }

  const Measurement& measurement_;
  const FittedModel& fitted_;
  Tangent tangent_;
  bool linear_;
  NormalEquations equations_;
  std::vector<BoundState> bound_states_;
  Eigen::VectorXd solution_;
};

/// The blocks of the last third of each log.
std::vector<bool> last_third(const Measurement& measurement) {
  std::vector<bool> blocks(static_cast<std::size_t>(measurement.block_count()), false);
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const LogPart& part = measurement.parts()[measurement.parts_of_log(log).first];
    mark_last_third(part.first_block, part.block_count, blocks);
  }
  return blocks;
}

/// The weights of the rows of `unseen` blocks at which the axis is within the travel that it makes in its log
/// outside them; zero at all others.
Eigen::VectorXd weights_within_travel(const Measurement& measurement, const std::vector<bool>& unseen) {
  const auto is_unseen = [&](Eigen::Index row) -> bool {
    return unseen[static_cast<std::size_t>(measurement.row_blocks()[static_cast<std::size_t>(row)])];
  };
  const auto position_m = [&](Eigen::Index row) {
    return measurement.position_m()[measurement.row_samples()[static_cast<std::size_t>(row)]];
  };
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(measurement.row_count());
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const RowRange own = measurement.rows_of_log(log);
    ValueRange seen{HUGE_VAL, -HUGE_VAL};
    for (Eigen::Index row = own.first; row < own.first + own.count; ++row) {
      if (!is_unseen(row)) seen = {std::min(seen.low, position_m(row)), std::max(seen.high, position_m(row))};
    }
    for (Eigen::Index row = own.first; row < own.first + own.count; ++row) {
      if (is_unseen(row) && seen.low <= position_m(row) && position_m(row) <= seen.high)
        weights(row) = measurement.row_weights()(row);
    }
  }
  return weights;
}

/// Adds the weighted squares of a residual to the blocks that it has not seen.
void add_squares(const Measurement& measurement, const std::vector<bool>& blocks,
                 const Eigen::VectorXd& residual_N, std::vector<double>& squares) {
  const std::vector<int>& block_of = measurement.row_blocks();
  for (Eigen::Index row = 0; row < residual_N.size(); ++row) {
    const auto block = static_cast<std::size_t>(block_of[static_cast<std::size_t>(row)]);
    if (blocks[block]) squares[block] += measurement.row_weights()(row) * residual_N(row) * residual_N(row);
  }
}

}  // namespace

void mark_last_third(int first_block, int block_count, std::vector<bool>& blocks) {
  const int end = first_block + block_count;
  for (int block = end - block_count / 3; block < end; ++block) {
    blocks[static_cast<std::size_t>(block)] = true;
  }
}

double rmse_of_blocks(const std::vector<double>& squared_error, const std::vector<double>& weight,
                      const std::vector<bool>& blocks) {
  double squares = 0.0;
  double weights = 0.0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (!blocks[b]) continue;
    squares += squared_error[b];
    weights += weight[b];
  }
  return std::sqrt(squares / std::max(weights, 1e-300));
}

void judge_on_unseen_data(const Measurement& measurement, FittedModel& fitted) {
  const PartialFits fits(measurement, fitted);
  const auto count = static_cast<std::size_t>(measurement.block_count());
  const auto folds = static_cast<std::size_t>(measurement.fold_count());
  std::vector<std::vector<bool>> unseen(folds, std::vector<bool>(count, false));
  for (std::size_t b = 0; b < count; ++b) {
    unseen[static_cast<std::size_t>(measurement.fold_of_block(static_cast<int>(b)))][b] = true;
  }
  unseen.push_back(last_third(measurement));
  std::vector<std::vector<double>> squares(unseen.size(), std::vector<double>(count, 0.0));
  parallel_for(unseen.size(), [&](std::size_t i) {
    const Eigen::VectorXd residual_N = fits.residual_without(unseen[i]);
    add_squares(measurement, unseen[i], residual_N, squares[i]);
    if (i < folds) return;
    const Eigen::VectorXd weights = weights_within_travel(measurement, unseen[i]);
    fitted.forward_within_travel_N =
        std::sqrt(weights.dot(residual_N.cwiseAbs2()) / std::max(weights.sum(), 1e-300));
  });
  fitted.block_squared_error.assign(count, 0.0);
  fitted.block_weight.assign(count, 0.0);
  for (Eigen::Index row = 0; row < measurement.row_count(); ++row) {
    const int block = measurement.row_blocks()[static_cast<std::size_t>(row)];
    fitted.block_weight[static_cast<std::size_t>(block)] += measurement.row_weights()(row);
  }
  for (std::size_t b = 0; b < count; ++b) {
    for (std::size_t fold = 0; fold < folds; ++fold) fitted.block_squared_error[b] += squares[fold][b];
  }
  const std::vector<bool>& last = unseen[folds];
  fitted.holdout_rmse_N =
      rmse_of_blocks(fitted.block_squared_error, fitted.block_weight, std::vector<bool>(count, true));
  fitted.forward_rmse_N = rmse_of_blocks(squares[folds], fitted.block_weight, last);
  fitted.last_third_holdout_rmse_N = rmse_of_blocks(fitted.block_squared_error, fitted.block_weight, last);
}

}  // namespace slipstack::workbench
