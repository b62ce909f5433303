// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <mutex>
#include <optional>
#include <vector>

#include "workbench/estimate/linear/force_trace.h"
#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// The force of a model along a log and its derivative by every gain: one Gauss-Newton step. The force is
/// linear in the gains of each effect while the others are held (model/composition.h), so two or three steps
/// converge.
///
/// Columns are evaluated at every sample with the firmware's basis(), multiplied by the derivative of the
/// composed force, and only then filtered to the rows. Cost: samples x gains x taps / row stride.
class Linearisation {
 public:
  /// Columns that do not depend on the gains are copied from `known` where it has them. `dry`: evaluate_dry()
  /// of the terms, where it is known.
  Linearisation(const Measurement& measurement, const Terms& terms, const Linearisation* known = nullptr,
                DryTrace dry = {});

  /// The columns of `near` at gains that are close enough for the columns to remain valid: costs
  /// near.force_at(). `dry` as above.
  Linearisation(const Linearisation& near, const Terms& terms, DryTrace dry = {});

  /// rows x unknowns: derivative of the force by each gain, filtered.
  const Eigen::MatrixXd& columns() const { return columns_; }
  /// What columns x gains should equal: the measured force, corrected for products of gains.
  const Eigen::VectorXd& target() const { return target_; }
  /// Measured force at the rows, shifted by the model's delay.
  const Eigen::VectorXd& measured_N() const { return measured_N_; }
  /// Force of the model at the rows.
  const Eigen::VectorXd& force_N() const { return force_N_; }
  Eigen::VectorXd residual_N() const { return measured_N_ - force_N_; }
  /// The model's force at every sample, not filtered; evaluated at the first call.
  const std::vector<double>& sample_force_N() const { return whole().force_N; }
  /// The sum of the dry forces at every sample, not modulated; evaluated at the first call.
  const std::vector<double>& sample_dry_N() const { return dry().dry_N; }

  /// Force at the rows of a model of the same effects with other gains or shapes. What is linear and keeps
  /// its shapes is columns x gains; only the rest is evaluated at the samples. `dry` (may be null):
  /// evaluate_dry() of the terms, taken where it is known and set where it is needed.
  Eigen::VectorXd force_at(const Terms& terms, DryTrace* dry = nullptr) const;
  /// Measured force less force_at().
  Eigen::VectorXd residual_at(const Terms& terms, DryTrace* dry = nullptr) const;

  /// Columns for an effect that the model does not contain.
  Eigen::MatrixXd columns_of(const Term& candidate) const;

 private:
  static constexpr std::array kWaysToAct{Acts::force, Acts::dry, Acts::dry_scale, Acts::total_scale};

  /// Derivative of the force by gain x basis at each sample, by how the gain acts; empty means one.
  class Derivatives {
   public:
    std::vector<double>& by(Acts acts) { return by_acts(acts, force_, dry_, dry_scale_, total_scale_); }
    const std::vector<double>& by(Acts acts) const {
      return by_acts(acts, force_, dry_, dry_scale_, total_scale_);
    }

   private:
    std::vector<double> force_, dry_, dry_scale_, total_scale_;
  };
  void retarget(const Eigen::VectorXd& force_N);
  void take_dry(DryTrace dry);
  const DryTrace& dry() const;
  const ForceTrace& whole() const;
  bool has(Acts acts) const;
  bool adds_up(Acts acts) const;
  Eigen::VectorXd linear_force(const Terms& terms, std::vector<bool>& evaluated) const;
  /// For the effect of term `term_index`.
  Derivatives derivatives_by(const EffectDescription& effect, std::size_t term_index) const;
  /// The same for an effect that is not in the model, kept for the next one that acts in the same way.
  const Derivatives& derivatives_beside(const EffectDescription& effect) const;
  /// One of them; for an effect that is not in the model, `term_index` is the number of terms.
  std::vector<double> derivative_by(Acts acts, std::size_t term_index) const;
  std::optional<Eigen::Index> lent_columns(const Linearisation* known, const Term& term) const;
  static void multiply_basis(const Term& term, const Derivatives& derivatives, std::size_t first,
                             std::size_t count, const double* basis, double* out);
  Eigen::MatrixXd build(const Term& term, const Derivatives& derivatives) const;

  const Measurement& measurement_;
  Terms terms_;
  // The force at the samples, of which a model without products needs nothing.
  mutable std::once_flag dry_known_;
  mutable std::once_flag whole_known_;
  mutable DryTrace dry_;
  mutable ForceTrace whole_;
  // A search asks for the columns of one candidate with hundreds of shapes: for each way that gains act.
  mutable std::array<std::once_flag, kWaysToAct.size()> beside_known_;
  mutable Derivatives beside_;
  Eigen::MatrixXd columns_;
  Eigen::VectorXd target_;
  Eigen::VectorXd measured_N_;
  Eigen::VectorXd force_N_;
};

/// The residual of a model at the rows, evaluated at every sample: what a Linearisation there would have.
Eigen::VectorXd residual_of(const Measurement& measurement, const Terms& terms);

/// The delay and low pass of the recorded force that the terms contain; none without `time_delay`.
MeasurementDynamics measurement_dynamics_of(const Terms& terms);

}  // namespace slipstack::workbench
