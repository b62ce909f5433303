// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/linear/linearisation.h"
#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/estimate/uncertainty/encoder_realisations.h"

namespace slipstack::workbench {

/// Variances at the rows [N^2].
struct RowVariances {
  Eigen::VectorXd noise;         ///< of force and acceleration
  Eigen::VectorXd quantisation;  ///< of the hysteresis force, by quantisation
};

/// Of rows where an axis of these masses, one for each log, has these changes by quantisation.
/// `force_noise_N`: of each log, white, before the filter.
RowVariances variances_at_rows(const Measurement& measurement, const std::vector<double>& mass_kg,
                               const std::vector<double>& force_noise_N, const ForceChanges& changes_N);

/// The noise of each log's force before the filter [N]: as given, or what the differences between samples
/// say, within the bounds that the saturated residual sets (residual_noise.h).
std::vector<double> force_noise_of_logs_N(const Measurement& measurement, const std::vector<double>& mass_kg,
                                          const Eigen::VectorXd& saturated_N, const ForceChanges& changes_N);

/// The variance that no model can explain, at each row [N^2]; its weighted mean is the square of the noise
/// floor. It has three parts:
/// - the noise of the force after the filter;
/// - the encoder's quantisation, through mass times acceleration;
/// - the effect of quantisation on the hysteresis. It is not white where the axis is slow, so it is
///   simulated (encoder_realisations.h). It counts as far as the saturated residual supports it.
Eigen::VectorXd unexplainable_variance(const RowVariances& rows, const Eigen::VectorXd& saturated_N,
                                       const Eigen::VectorXd& usable);

/// Lowers the noise floor of the measurement to what free curves beside `model` leave room for, where that is
/// less. The reference model of weigh_rows() may be further from the axis than a model that was found since:
/// free curves do not describe a memory, nor products of two dependences, and what they leave of these would
/// count as noise. Call after weigh_rows(), where nothing else reads the floor. Cost: rows x (gains + 14)^2.
void lower_noise_floor(Measurement& measurement, const Linearisation& model);

/// Lowers the noise floor to `left_N`, the error of a model on data that it was not fitted to, where that is
/// less: noise is in those data too, so a model that leaves less than the floor disproves it. A line above
/// the bandwidth, for example, is noise between samples and not at the rows.
void bound_noise_floor(Measurement& measurement, double left_N);

/// Both, by a model whose error a command tells.
void lower_noise_floor(Measurement& measurement, const Linearisation& model, double left_N);

/// Moving average over neighbouring rows, some filter lengths wide.
Eigen::VectorXd smoothed(const Eigen::VectorXd& values);

}  // namespace slipstack::workbench
