// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/composition.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// The force of a model at every sample of a log, by the firmware's basis functions.
struct ForceTrace {
  std::vector<double> dry_N;                      ///< sum of `dry`, not modulated
  std::vector<std::vector<double>> dry_scales;    ///< 1 + modulation, per term; empty where it has none
  std::vector<std::vector<double>> total_scales;  ///< the same for the whole force
  std::vector<double> dry_factor;                 ///< product of dry_scales; empty means one
  std::vector<double> total_factor;               ///< product of total_scales; empty means one
  std::vector<double> force_N;

  ComposedForce at(std::size_t sample) const;
};

/// `dry_N`, the sum of the dry forces where it is known, saves evaluating them; the hysteresis costs most.
ForceTrace evaluate_force(const Measurement& measurement, const Terms& terms,
                          const std::vector<double>* dry_N = nullptr);

/// The force of a model along a log and its derivative by every gain: one Gauss-Newton step. The force is
/// linear in the gains of each effect while the others are held (model/composition.h), so two or three steps
/// converge.
///
/// Columns are evaluated at every sample with the firmware's basis(), multiplied by the derivative of the
/// composed force, and only then filtered to the rows. Cost: samples x gains x taps / row stride.
class Linearisation {
 public:
  /// Columns that do not depend on the gains are copied from `known` where it has them.
  Linearisation(const Measurement& measurement, const Terms& terms, const Linearisation* known = nullptr);

  /// The columns of `near` at gains that are close enough for the columns to remain valid: costs one
  /// evaluation.
  Linearisation(const Linearisation& near, const Terms& terms);

  /// rows x unknowns: derivative of the force by each gain, filtered.
  const Eigen::MatrixXd& columns() const { return columns_; }
  /// What columns x gains should equal: the measured force, corrected for products of gains.
  const Eigen::VectorXd& target() const { return target_; }
  /// Measured force at the rows, shifted by the model's delay.
  const Eigen::VectorXd& measured_N() const { return measured_N_; }
  /// Force of the model at the rows.
  const Eigen::VectorXd& force_N() const { return force_N_; }
  Eigen::VectorXd residual_N() const { return measured_N_ - force_N_; }
  /// The model's force at every sample, not filtered.
  const std::vector<double>& sample_force_N() const { return trace_.force_N; }
  /// The sum of the dry forces at every sample, not modulated.
  const std::vector<double>& sample_dry_N() const { return trace_.dry_N; }

  /// Columns for an effect that the model does not contain.
  Eigen::MatrixXd columns_of(const Term& candidate) const;

 private:
  /// Derivative of the force by gain x basis at each sample, by how the gain acts; empty means one.
  struct Derivatives {
    std::vector<double> force;
    std::vector<double> dry;
    std::vector<double> dry_scale;
    std::vector<double> total_scale;
  };
  void retarget();
  /// For the effect of term `term_index`; for an effect that is not in the model, the number of terms.
  Derivatives derivatives_by(const EffectDescription& effect, std::size_t term_index) const;
  std::vector<double> derivative_by(Acts acts, std::size_t term_index) const;
  std::optional<Eigen::Index> lent_columns(const Linearisation* known, const Term& term) const;
  static void multiply_basis(const Term& term, const Derivatives& derivatives, std::size_t first,
                             std::size_t count, const double* basis, double* out);
  Eigen::MatrixXd build(const Term& term, const Derivatives& derivatives) const;

  const Measurement& measurement_;
  Terms terms_;
  ForceTrace trace_;
  Eigen::MatrixXd columns_;
  Eigen::VectorXd target_;
  Eigen::VectorXd measured_N_;
  Eigen::VectorXd force_N_;
};

/// The residual of a model at the rows, evaluated without its columns: what a Linearisation there would have.
Eigen::VectorXd residual_of(const Measurement& measurement, const Terms& terms);

/// The delay and low pass of the recorded force that the terms contain; none without `time_delay`.
MeasurementDynamics measurement_dynamics_of(const Terms& terms);

}  // namespace slipstack::workbench
