// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/identify/terms.h"

namespace slipstack::workbench {

/// The force of a model along a log, and how it changes with every gain: one Gauss-Newton step. The force is
/// linear in each effect's gains while the others are held (effect.h), so two or three steps settle it.
///
/// Columns are evaluated at every sample with the firmware's basis(), multiplied by what the other effects make
/// of them, and only then filtered to the rows. Cost: samples x gains x taps / row stride.
class Linearisation {
 public:
  Linearisation(const Measurement& measurement, const Terms& terms);

  /// rows x unknowns: derivative of the force by each gain, filtered.
  const Eigen::MatrixXd& columns() const { return columns_; }
  /// What columns x gains should equal: measured force, corrected for products of gains.
  const Eigen::VectorXd& target() const { return target_; }
  /// Measured force at the rows, shifted by the model's delay.
  const Eigen::VectorXd& measured_N() const { return measured_N_; }
  /// Force of the model at the rows.
  const Eigen::VectorXd& force_N() const { return force_N_; }
  Eigen::VectorXd residual_N() const { return measured_N_ - force_N_; }
  /// The model's force and dry friction at every sample, not filtered.
  const std::vector<double>& sample_force_N() const { return sample_force_N_; }

  /// Columns for an effect that the model does not contain.
  Eigen::MatrixXd columns_of(const Term& candidate) const;

  /// Tangent stiffness of the hysteresis at the rows [N/m]: how encoder quantisation becomes force.
  Eigen::VectorXd tangent_stiffness_N_per_m() const;

 private:
  /// What multiplies a gain's basis at each sample; empty means one.
  struct Factors {
    std::vector<double> force;
    std::vector<double> dry;
    std::vector<double> dry_scale;
    std::vector<double> total_scale;
  };
  void evaluate(const Terms& terms);
  Factors factors_for(std::size_t term_index) const;
  Eigen::MatrixXd build(const Term& term, const Factors& factors) const;

  const Measurement& measurement_;
  Terms terms_;
  std::vector<double> plain_N_;                    ///< sum of `force` terms
  std::vector<double> dry_N_;                      ///< sum of `dry` terms
  std::vector<std::vector<double>> dry_scales_;    ///< 1 + modulation, per term; empty where it has none
  std::vector<std::vector<double>> total_scales_;
  std::vector<double> dry_factor_;    ///< product of dry_scales_; empty means one
  std::vector<double> total_factor_;  ///< product of total_scales_; empty means one
  std::vector<double> sample_force_N_;
  Eigen::MatrixXd columns_;
  Eigen::VectorXd target_;
  Eigen::VectorXd measured_N_;
  Eigen::VectorXd force_N_;
};

/// Delay that the terms declare, 0 without.
double delay_s(const Terms& terms);

}  // namespace slipstack::workbench
