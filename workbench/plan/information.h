// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "workbench/diagnose/evidence/criterion.h"
#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// The information of a motion, recorded once, about some effects: for each ordered pair, the distance of the
/// force of one from the space spanned by the baseline and the other.
///
/// It consists of sums over rows only, so that the information of several segments of a motion is the sum of
/// theirs.
class Information {
 public:
  /// An effect as it is expected to be, and further shapes at which it may explain the force of another
  /// effect.
  struct Expected {
    Term term;
    std::vector<std::vector<double>> alternatives;  ///< shapes, besides those of the term
  };

  /// The information of every group of rows of a measurement: rows with groups[row] == k contribute to the
  /// k-th result, those with a negative group to none. `scatter`: of the rows about a model of all that acts.
  static std::vector<Information> of(const Measurement& measurement, const FittedModel& base,
                                     const std::vector<Expected>& effects, const std::vector<int>& groups,
                                     int group_count, const ResidualScale& scatter);

  void add(const Information& other);
  /// The information of `times` as many rows of the same kind.
  void repeat(double times);

  struct Figure {
    /// Expected growth of chi squared of independent rows without the effect, or with the other effect in
    /// its place.
    double chi_squared = 0.0;
    double angle_deg = 0.0;  ///< to the space spanned by the other effect; 90 without another
    double rows = 0.0;       ///< number of independent rows
  };
  /// Of effect `i` against the baseline alone.
  Figure alone(std::size_t i) const;
  /// Of effect `i` against effect `j` in its place.
  Figure against(std::size_t i, std::size_t j) const;
  std::size_t effect_count() const { return force_.size(); }

 private:
  double unexplained(std::size_t i, const std::vector<Eigen::Index>& known) const;

  Eigen::MatrixXd gram_;                            ///< of all columns, over the variance of the mean of rows
                                                    ///< that are worth one
  std::vector<Eigen::Index> base_;                  ///< columns of the baseline
  std::vector<Eigen::Index> force_;                 ///< the force of each effect
  std::vector<std::vector<Eigen::Index>> spanned_;  ///< columns that each effect spans
  double rows_ = 0.0;
};

}  // namespace slipstack::workbench
