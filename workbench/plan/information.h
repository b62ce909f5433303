// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// What a motion, recorded once, would say about some effects: for each ordered pair, how far the force of
/// one is from all that the baseline and the other can make.
///
/// Sums over rows only, so that the information of several pieces of motion is the sum of theirs.
class Information {
 public:
  /// An effect as it is expected to be, and shapes at which another may try to imitate with it.
  struct Expected {
    Term term;
    std::vector<std::vector<double>> residual_makers;  ///< shapes; those of the term are added
  };

  /// The information of every row group of a measurement: rows with groups[row] == k go to the k-th result;
  /// negative: nowhere. `noise_N`: rms noise at the rows.
  static std::vector<Information> of(const Measurement& measurement, const FittedModel& base,
                                     const std::vector<Expected>& effects, const std::vector<int>& groups,
                                     int group_count, double noise_N);

  void add(const Information& other);
  /// As if there were so many times the rows, alike.
  void repeat(double times);

  struct Figure {
    double chi_squared =
        0.0;                 ///< expected growth of chi squared without the effect, or with the other for it
    double angle_deg = 0.0;  ///< to what the other makes; 90 without another
    double rows = 0.0;
  };
  /// Of effect `i` beside the baseline alone.
  Figure alone(std::size_t i) const;
  /// Of effect `i` where `j` is taken for it.
  Figure against(std::size_t i, std::size_t j) const;
  std::size_t effect_count() const { return force_.size(); }

 private:
  double left_of(std::size_t i, const std::vector<Eigen::Index>& known) const;

  Eigen::MatrixXd gram_;                                   ///< of all columns, over the noise's variance
  std::vector<Eigen::Index> base_;                         ///< columns of the baseline
  std::vector<Eigen::Index> force_;                        ///< the force of each effect
  std::vector<std::vector<Eigen::Index>> residual_maker_;  ///< what each effect can make
  double rows_ = 0.0;
};

}  // namespace slipstack::workbench
