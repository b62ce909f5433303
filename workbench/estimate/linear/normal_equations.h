// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/linear/bounded_least_squares.h"
#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// Rows of each part of a block: blocks are contiguous and in order.
std::vector<RowRange> block_ranges(const Measurement& measurement, int parts = 1);

/// The least rows of a part of a block. Noise is uncorrelated over far fewer: the filter reaches over nine.
inline constexpr Eigen::Index kLeastRowsOfPart = 45;

/// Into how many parts the blocks are divided where the scatter between parts is an error: each is several
/// times longer than noise is correlated.
int parts_of_block(const Measurement& measurement);

/// Normal equations of a regression, one set for each block of rows. They suffice for fits, for
/// cross-validation by blocks, and for standard errors that do not assume independent residuals.
class NormalEquations {
 public:
  /// Accumulates columns (rows x unknowns) against `target`, with the weights by which models are fitted.
  /// Each block is divided into `parts_of_block` parts; more than one only for standard_errors(). Cost: rows
  /// x unknowns^2.
  NormalEquations(const Measurement& measurement, const Eigen::MatrixXd& columns,
                  const Eigen::VectorXd& target, int parts_of_block = 1);

  /// Without rows yet, for add(). Block b belongs to fold b % folds.
  NormalEquations(Eigen::Index unknowns, int blocks, int folds);
  /// Adds the rows of other equations, block by block, from `block` on. Call sum_up() after the last.
  void add(const NormalEquations& rows, int block);
  /// Adds one block of other equations of this size, serialised by numbers_of().
  void add(const std::vector<double>& numbers, int block);
  /// One block, serialised: unknowns^2 + unknowns + 2 numbers.
  std::vector<double> numbers_of(int block) const;
  /// Sums the blocks to the whole.
  void sum_up();

  /// These equations with further columns; `columns` are those from which these equations were made.
  NormalEquations with(const Measurement& measurement, const Eigen::MatrixXd& columns,
                       const Eigen::MatrixXd& further, const Eigen::VectorXd& target) const;

  /// These equations with another target.
  NormalEquations with_target(const Measurement& measurement, const Eigen::MatrixXd& columns,
                              const Eigen::VectorXd& target) const;

  /// The same without the blocks, at a fraction of the cost: enough for fit() and training_error().
  NormalEquations sum_with(const Measurement& measurement, const Eigen::MatrixXd& columns,
                           const Eigen::MatrixXd& further, const Eigen::VectorXd& target) const;
  NormalEquations sum_with_target(const Measurement& measurement, const Eigen::MatrixXd& columns,
                                  const Eigen::VectorXd& target) const;

  Eigen::Index unknowns() const { return unknowns_; }
  /// Sum of the row weights: a sum of squared errors divided by it is a mean square.
  double weight() const { return total_.weight; }
  double weight(int block) const { return blocks_[static_cast<std::size_t>(block)].weight; }
  int block_count() const { return static_cast<int>(blocks_.size()); }
  const Eigen::MatrixXd& gram() const { return total_.gram; }
  const Eigen::VectorXd& right() const { return total_.right; }

  /// Sum of squared errors of `value` in one block, or in all.
  double squared_error(const Eigen::VectorXd& value, int block) const;
  double squared_error(const Eigen::VectorXd& value) const;

  /// Bounds and regularisation of the unknowns.
  struct Constraints {
    Eigen::VectorXd lower;
    Eigen::VectorXd upper;
    Eigen::MatrixXd penalty;        ///< added to the normal matrix: inverse prior covariance x noise variance
    SumDifferencePairs pairs = {};  ///< of unknowns, see BoundedProblem
  };

  BoundedSolution fit(const Constraints& constraints, const std::vector<BoundState>& start = {}) const;
  /// The same fit with `damping` times the squared change from `here` added to the cost, each unknown in
  /// units of its column: a step of Levenberg and Marquardt.
  BoundedSolution fit_near(const Eigen::VectorXd& here, double damping, const Constraints& constraints,
                           const std::vector<BoundState>& start) const;

  /// Root mean square of the residual of fit(), the penalty included.
  double training_error(const Constraints& constraints, const std::vector<BoundState>& start) const;
  /// The same fit without the blocks for which `held_out` is set.
  BoundedSolution fit_without(const std::vector<bool>& held_out, const Constraints& constraints,
                              const std::vector<BoundState>& start) const;

  /// The error that such a fit leaves in the blocks that it has not seen; zero where these have no rows.
  double error_without(const std::vector<bool>& held_out, const Constraints& constraints,
                       const std::vector<BoundState>& start) const;

  struct CrossValidation {
    double rmse = 0.0;
    std::vector<double> block_squared_error;  ///< of each block by the fit to the other folds
  };
  /// Blocked cross-validation: the error of each fold by a fit to the others.
  CrossValidation cross_validate(const Constraints& constraints, const std::vector<BoundState>& start) const;

  /// Standard errors that allow for correlation within blocks: the scatter of the bounded solution when the
  /// sign of each block's noise is drawn at random (wild cluster bootstrap; Cameron, Gelbach & Miller 2008),
  /// widened where few blocks determine an unknown. Unknowns near a bound scatter to one side only; zero for
  /// those at a bound. `sums` (unknowns x any number): further linear combinations, one in each column, whose
  /// errors follow those of the unknowns. Cost: 200 bounded solutions. Implemented in cluster_errors.cpp.
  Eigen::VectorXd standard_errors(const BoundedSolution& solution, const Constraints& constraints,
                                  const Eigen::MatrixXd& sums = {}) const;

  /// Variance of each free unknown by errors of the target that recur in every block alike, beyond what
  /// standard_errors() already has by their scatter between blocks: the mean over the realisations
  /// `errors_N` of the square of the sum of what the blocks contribute, less the sum of their squares; then
  /// that of the `sums`, as above. Cost: rows x unknowns for each realisation. Implemented in
  /// cluster_errors.cpp.
  Eigen::VectorXd recurring_variance(const Measurement& measurement, const Eigen::MatrixXd& columns,
                                     const std::vector<Eigen::VectorXd>& errors_N,
                                     const BoundedSolution& solution, const Constraints& constraints,
                                     const Eigen::MatrixXd& sums = {}) const;

 private:
  struct Part {
    Eigen::MatrixXd gram;
    Eigen::VectorXd right;
    double target_squared = 0.0;
    double weight = 0.0;
    void add(const Part& other, double sign);
    double squared_error(const Eigen::VectorXd& value) const;
  };
  NormalEquations() = default;
  static Part widened(const Part& part, const Eigen::Ref<const Eigen::VectorXd>& weights,
                      const Eigen::Ref<const Eigen::MatrixXd>& columns,
                      const Eigen::Ref<const Eigen::MatrixXd>& further,
                      const Eigen::Ref<const Eigen::VectorXd>& target);
  static Part nothing(Eigen::Index unknowns);

  Eigen::Index unknowns_ = 0;
  int folds_ = 1;
  int parts_of_block_ = 1;
  std::vector<Part> blocks_;
  Part total_;
};

}  // namespace slipstack::workbench
