// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// The force of a model at every sample of a log, by the firmware's basis functions.
struct ForceTrace {
  std::vector<double> dry_N;                      ///< sum of `dry` terms, not modulated
  std::vector<std::vector<double>> dry_scales;    ///< 1 + modulation, per term; empty where it has none
  std::vector<std::vector<double>> total_scales;  ///< the same for the whole force
  std::vector<double> dry_factor;                 ///< product of dry_scales; empty means one
  std::vector<double> total_factor;               ///< product of total_scales; empty means one
  std::vector<double> force_N;
};

/// `dry_N`, where the sum of the dry terms is known, saves evaluating them: hysteresis costs most of all.
ForceTrace evaluate_force(const Measurement& measurement, const Terms& terms,
                          const std::vector<double>* dry_N = nullptr);

/// The force of a model along a log, and how it changes with every gain: one Gauss-Newton step. The force is
/// linear in each effect's gains while the others are held (effect.h), so two or three steps settle it.
///
/// Columns are evaluated at every sample with the firmware's basis(), multiplied by what the other effects
/// make of them, and only then filtered to the rows. Cost: samples x gains x taps / row stride.
class Linearisation {
 public:
  /// `known` may lend columns that do not depend on the gains.
  Linearisation(const Measurement& measurement, const Terms& terms, const Linearisation* known = nullptr);

  /// The same columns at other gains, close enough for the columns to hold: costs one evaluation.
  Linearisation(const Linearisation& near, const Terms& terms);

  /// rows x unknowns: derivative of the force by each gain, filtered.
  const Eigen::MatrixXd& columns() const { return columns_; }
  /// What columns x gains should equal: measured force, corrected for products of gains.
  const Eigen::VectorXd& target() const { return target_; }
  /// Measured force at the rows, shifted by the model's delay.
  const Eigen::VectorXd& measured_N() const { return measured_N_; }
  /// Force of the model at the rows.
  const Eigen::VectorXd& force_N() const { return force_N_; }
  Eigen::VectorXd residual_N() const { return measured_N_ - force_N_; }
  /// The model's force at every sample, not filtered.
  const std::vector<double>& sample_force_N() const { return trace_.force_N; }
  /// The same of the dry terms, before anything modulates them.
  const std::vector<double>& sample_dry_N() const { return trace_.dry_N; }

  /// Columns for an effect that the model does not contain.
  Eigen::MatrixXd columns_of(const Term& candidate) const;

 private:
  /// What multiplies a gain's basis at each sample; empty means one.
  struct Factors {
    std::vector<double> force;
    std::vector<double> dry;
    std::vector<double> dry_scale;
    std::vector<double> total_scale;
  };
  void retarget();
  /// Of an effect that is the model's term `term_index`, or none of them.
  Factors factors_for(const EffectDescription& effect, std::size_t term_index) const;
  std::optional<Eigen::Index> lent_columns(const Linearisation* known, const Term& term) const;
  static void multiply_basis(const Term& term, const Factors& factors, std::size_t first, std::size_t count,
                             const double* basis, double* out);
  Eigen::MatrixXd build(const Term& term, const Factors& factors) const;

  const Measurement& measurement_;
  Terms terms_;
  ForceTrace trace_;
  Eigen::MatrixXd columns_;
  Eigen::VectorXd target_;
  Eigen::VectorXd measured_N_;
  Eigen::VectorXd force_N_;
};

/// Lag of the force that the terms declare, none without.
MeasurementDynamics measurement_dynamics_of(const Terms& terms);

}  // namespace slipstack::workbench
