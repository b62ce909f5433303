// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <complex>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "workbench/report/pictures.h"

// What a residual tells in frequency and in lag, and the response of the axis beside that of its model. Rows
// that are not usable, and gaps between parts, are left out.
namespace slipstack::workbench {

/// The share of the residual's power that follows the acceleration linearly, at each frequency up to the
/// bandwidth. Velocity and position follow from the acceleration, so that this is what any linear effect of
/// the motion could explain: inertia, viscous friction, a spring, a resonance.
struct MotionCoherence {
  std::vector<double> frequency_Hz;
  std::vector<double> coherence;
  double chance = 1.0;  ///< exceeded by chance at 5 % of the frequencies
};
/// Empty where fewer than fifteen segments of 64 rows fit into the log. O(rows log segment).
MotionCoherence motion_coherence(const Measurement& measurement, const Eigen::VectorXd& residual_N);

/// Correlation of the residual with itself, up to a lag of a second or 400 rows; one at lag zero.
struct Autocorrelation {
  std::vector<double> lag_s;
  std::vector<double> correlation;
  std::vector<double> white;  ///< of white noise in the recorded force, after the filter of the rows
};
/// Empty where the residual is zero. O(rows x lags).
Autocorrelation autocorrelation(const Measurement& measurement, const Eigen::VectorXd& residual_N);

/// Acceleration over force, 1/kg (rotary: 1/(kg m2)); one over the mass where the axis is a rigid mass.
/// Friction makes it depend on the motion: it is the response in this log.
struct AxisResponse {
  std::vector<double> frequency_Hz;
  std::vector<std::complex<double>> per_kg;
  std::vector<double> deviation;  ///< relative standard deviation
};
/// Empty as motion_coherence().
AxisResponse axis_response(const Measurement& measurement, const Eigen::VectorXd& force_N);

/// Adds `coherence`, `autocorrelation` and `response` of one or two models to the data of the residual
/// charts, where there are such. Of the response what is certain to 20 %, else null.
void add_residual_dynamics(nlohmann::json& data, const Measurement& measurement, const ForceRows& before,
                           const ForceRows* after);

}  // namespace slipstack::workbench
