// SPDX-License-Identifier: Apache-2.0
// Hysteresis of a force transducer as Maxwell elements: extraction and correction of readings ([3]).
#pragma once

#include <string_view>
#include <vector>

#include "workbench/papers/analysis/load_steps.h"

namespace slipstack::workbench {

/// The reading of a transducer: S·x + linearity(x) + Σ kᵢ·zᵢ + offset, zᵢ a stop operator of the load, |zᵢ| ≤
/// Δᵢ.
class TransducerModel {
 public:
  /// Elements: stiffness in mV/V per N (all of one sign: a reading on the way up may lie above or below that
  /// on the way down) and slip load in N. Linearity: a table over load, straight between, zero beyond.
  TransducerModel(double sensitivity, std::vector<double> stiffness, std::vector<double> slip_N,
                  std::vector<double> table_N, std::vector<double> table_mV_per_V);

  double sensitivity() const { return sensitivity_; }
  const std::vector<double>& stiffness() const { return stiffness_; }
  const std::vector<double>& slip_N() const { return slip_N_; }
  double linearity(double load_N) const;

  /// The hysteresis at a load that is reached from the present one without reversal, mV/V; the state is not
  /// changed.
  double hysteresis_at(double load_N) const;
  double reading_at(double load_N) const {
    return sensitivity_ * load_N + linearity(load_N) + hysteresis_at(load_N);
  }
  void move_to(double load_N);
  void reset();

  /// The load whose reading is `signal`, by bisection until it is known to 1e-9 of full scale ([3], section
  /// 6): 32 readings of the model. Readings beyond the range give its ends, −5 % and 105 % of full scale.
  double load_of(double signal, double full_scale_N) const;

 private:
  double sensitivity_;
  std::vector<double> stiffness_;
  std::vector<double> slip_N_;
  std::vector<double> table_N_;
  std::vector<double> table_;
  double load_N_ = 0.0;
  std::vector<double> elongation_N_;
};

/// By the formula of [3], section 5: from the first rise, hysteresis separated from linearity and turned so
/// that dh/dF = 0 at full scale, Δᵢ = xᵢ and kᵢ the change of slope at xᵢ. After preloads the rise is a
/// branch, 2·y(x/2), hence Δᵢ = xᵢ/2 then. Changes of slope of the other sign are left out as noise; throws
/// std::invalid_argument when they make up more than a third: the curve is not concave.
///
/// On a rise without preloads (h_up + h_down)/2 holds a part of the hysteresis, since the loop does not
/// close. `linearity`, a record after preloads where there is one, gives the linearity deviation instead.
TransducerModel extract_by_formula(const StepRecord& record, const StepRecord* linearity = nullptr);

/// By least squares over the whole record: kᵢ ≥ 0 (in the loop's sense) on forty slip loads, sensitivity,
/// quadratic and cubic linearity deviation, offset and drift at once. No separation in advance is needed.
TransducerModel extract_by_least_squares(const StepRecord& record);

/// The elements of a model with the line and the linearity deviation of another record: [3] separates those
/// from every measurement anew, because the sensitivity of a first rise is not that of a cycle after
/// preloads. The table has the record's levels.
TransducerModel with_line_of(const TransducerModel& model, const StepRecord& record);

/// Errors of a model on a record's cycle.
struct TransducerErrors {
  std::vector<double> residual_mV_per_V;  // reading less model, of every reading of the cycle
  std::vector<double> load_error_N;       // corrected load less true load
  double largest_mV_per_V = 0.0;
  double largest_load_N = 0.0;
  double rms_load_N = 0.0;
  /// Standard uncertainty of a load from the remaining error, N: a rectangular distribution of that half
  /// width.
  double uncertainty_N = 0.0;
};

/// Follows the record through the model with the known loads (residuals), and through bisection with the
/// readings alone (load errors). Offset is taken from the zero before the cycle, drift from the zero after
/// it, in proportion to time.
TransducerErrors errors_of(TransducerModel model, const StepRecord& record);

/// The calibration curve alone, without elements: the usual correction.
TransducerModel line_and_linearity(const StepRecord& record);

}  // namespace slipstack::workbench
