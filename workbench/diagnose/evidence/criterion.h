// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "workbench/estimate/nonlinear/fitted_model.h"

namespace slipstack::workbench {

/// A difference of two criteria approximates twice the logarithm of a Bayes factor; less than this is "not
/// worth more than a bare mention" (Kass and Raftery 1995, "Bayes factors", section 3.2).
inline constexpr double kBareMention = 2.0;
/// Whether the log supports a model whose criterion is `difference` above that of another.
inline bool is_supported(double difference) {
  return difference < -kBareMention;
}

/// How far, and how independently of each other, the rows of a log scatter about a model.
struct ResidualScale {
  double rms_N = 0.0;      ///< weighted, at the rows
  double inflation = 1.0;  ///< how many rows are worth one independent row: f below
};

/// What a criterion charges a model for.
struct Complexity {
  double parameters = 0.0;  ///< effective number of gains, and searched shapes: p + s below
  double ln_starts = 0.0;
  /// ln(W / f) (p + s) + 2 ln(starts); `independent_rows`: W / f.
  double cost(double independent_rows) const;
};

/// What the data say about models: the smaller, the better, whether or not one model contains the other.
///
///   criterion = W / f ln(mse) + ln(W / f) (p + s) + 2 ln(starts)
///
/// the Bayesian information criterion (Schwarz 1978) for dependent residuals, in units of twice the
/// log-likelihood of independent rows. W: sum of the weights by which the model was fitted; mse: weighted
/// mean square of its residual. p = tr(H^-1 X'WX), H = X'WX + penalty: the effective number of its gains; a
/// smooth map of twenty values counts as few. s: searched shapes of the effects beside the baseline; starts:
/// product of the numbers of pitches or frequencies that their searches compared, and of the number of
/// effects that each was chosen from (extended criterion, Chen and Chen 2008).
///
/// f = tr(H^-1 J) / (mse p), at least 1: how many rows are worth one independent row (composite likelihood;
/// Varin and Vidoni 2005, Gao and Song 2010). J: the variance of the scores X_i' w_i r_i, summed within
/// clusters before they are squared, for clusters in time and in state at once (Cameron, Gelbach and Miller
/// 2011): what the form of a model misses returns whenever the axis is at the same place at the same speed.
/// Where the motion repeats, the clusters in time are phases of it, over all periods.
/// All models of a comparison have the same f, that of the lowest error among them (Burnham and Anderson
/// 2002, section 2.5): otherwise the scatter of f, multiplied by the gains that all models share, decides.
class Criterion {
 public:
  /// `baseline`: its shapes do not count, since every model has them. `choices`: number of effects among
  /// which a search chooses. Keeps a reference to the measurement. Cost: O(rows log rows).
  Criterion(const Measurement& measurement, const Terms& baseline, std::size_t choices);

  /// The criterion of each model. Comparable only within one call. Cost: rows x gains^2 for
  /// the one of lowest error, rows for each other.
  std::vector<double> of(const std::vector<const FittedModel*>& models) const;
  /// The criterion of `model` less that of `other`: negative where `model` is the better.
  double difference(const FittedModel& model, const FittedModel& other) const;
  /// The scatter about a model, by which others of the same comparison are judged. Cost: rows x gains^2.
  ResidualScale residual_scale(const FittedModel& model) const;
  /// Gains at a bound do not count.
  Complexity complexity_of(const FittedModel& model) const;

 private:
  /// The searched shapes of the effects beside the baseline, and what they were chosen from.
  Complexity choices_of(const Terms& terms) const;
  double inflation_of(const FittedModel& model, double count, double mean_square) const;

  const Measurement& measurement_;
  Terms baseline_;
  double ln_choices_;
  std::vector<std::size_t> interval_of_row_;  ///< clusters in time
  std::vector<std::size_t> state_of_row_;     ///< clusters in position and velocity
  std::vector<std::size_t> both_of_row_;      ///< clusters in both; empty: hardly more than a row each
};

}  // namespace slipstack::workbench
