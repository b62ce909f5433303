// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/linear/bounded_least_squares.h"
#include "workbench/estimate/measurement/measurement.h"

namespace slipstack::workbench {

/// Normal equations of a regression, one set for each block of rows: enough to fit, to judge on blocks that
/// the fit has not seen, and to give standard errors that do not believe residuals to be independent.
class NormalEquations {
 public:
  /// Accumulates columns (rows x unknowns) against `target`, rows weighted as the measurement says. With
  /// `parts_of_block`, blocks so many times as short, for standard_errors() alone. Cost: rows x unknowns^2.
  NormalEquations(const Measurement& measurement, const Eigen::MatrixXd& columns,
                  const Eigen::VectorXd& target, int parts_of_block = 1);

  /// Without any row yet: for add(). `folds`: block b is of fold b % folds.
  NormalEquations(Eigen::Index unknowns, int blocks, int folds);
  /// Adds the rows of other equations, block by block, from `block` on; sum_up() when all are there.
  void add(const NormalEquations& rows, int block);
  /// Adds numbers that other equations of this size gave for one block (numbers_of()).
  void add(const std::vector<double>& numbers, int block);
  /// All of one block: unknowns^2 + unknowns + 2 numbers.
  std::vector<double> numbers_of(int block) const;
  /// Makes the whole of the blocks.
  void sum_up();

  /// These equations with further columns; `columns` are those that these equations were made of.
  NormalEquations with(const Measurement& measurement, const Eigen::MatrixXd& columns,
                       const Eigen::MatrixXd& further, const Eigen::VectorXd& target) const;

  /// These equations with another target.
  NormalEquations with_target(const Measurement& measurement, const Eigen::MatrixXd& columns,
                              const Eigen::VectorXd& target) const;

  Eigen::Index unknowns() const { return unknowns_; }
  /// Sum of the weights of the rows: squared errors over it are mean squares.
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
    Eigen::MatrixXd penalty;  ///< added to the normal matrix: inverse prior covariance x noise variance
    EachWay each_way = {};    ///< pairs of unknowns, see BoundedProblem
  };

  BoundedSolution fit(const Constraints& constraints, const std::vector<BoundState>& start = {}) const;

  struct CrossValidation {
    double rmse = 0.0;
    std::vector<double> block_squared_error;  ///< each block judged by the fit to the other folds
  };
  /// Blocked cross-validation: each fold in turn is judged by a fit to the others.
  CrossValidation cross_validate(const Constraints& constraints, const std::vector<BoundState>& start) const;

  /// Standard errors that allow for correlation within blocks: the scatter of the bounded solution when each
  /// block's noise has another sign (wild cluster bootstrap; Cameron, Gelbach & Miller 2008), widened where
  /// few blocks tell of an unknown. Unknowns that lie near a bound scatter on one side of it; zero for those
  /// at rest on one. Cost: 200 bounded solutions.
  Eigen::VectorXd standard_errors(const BoundedSolution& solution, const Constraints& constraints) const;

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
  static Part nothing(Eigen::Index unknowns);

  Eigen::Index unknowns_ = 0;
  int folds_ = 1;
  std::vector<Part> blocks_;
  Part total_;
};

}  // namespace slipstack::workbench
