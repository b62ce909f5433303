// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// A model's force beside the measured one, at the rows.
struct ForceRows {
  Eigen::VectorXd measured_N;
  Eigen::VectorXd model_N;
  Eigen::VectorXd residual_N() const { return measured_N - model_N; }
};

/// Measured force and the force of a fitted model, at the rows.
ForceRows rows_of(const FittedModel& fitted);

/// Adds what the report draws of a measurement and a model: series, loops, profiles, spectrum, header and
/// notes. `after` (may be null) is a second model, drawn beside the first.
void add_pictures(nlohmann::json& data, const Measurement& measurement, const ForceRows& before,
                  const ForceRows* after);

/// Of these, loops, profiles and spectrum.
void add_residual_charts(nlohmann::json& data, const Measurement& measurement, const ForceRows& before,
                         const ForceRows* after);

/// The mean of a force, given at the rows, over the coordinate of each profile, in their order: what a
/// missing effect would leave there.
nlohmann::json expected_means(const Measurement& measurement, const Eigen::VectorXd& expected_N);

/// Adds to the profiles that add_pictures() drew the residual that a missing effect is expected to leave, at
/// the rows, under `name`.
void add_expected(nlohmann::json& data, const Measurement& measurement, const std::string& name,
                  const Eigen::VectorXd& expected_N);

}  // namespace slipstack::workbench
