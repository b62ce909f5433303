// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// The force of term `index` of the model at the rows.
Eigen::VectorXd force_of(const FittedModel& model, std::size_t index);

/// For each row that belongs to a traverse of at least `length_m`: the distance from the row before, m; zero
/// for other rows. A traverse ends where the axis has moved back by `length_m`, and at the end of
/// a log. Rows whose filter reaches samples that repair() left out are zero.
Eigen::VectorXd distance_in_traverses(const Measurement& measurement, double length_m);

/// The share of the force `claimed_N` that the measurement supports: 1 all of it, 0 nothing, negative the
/// opposite. `left_N`: the residual of the model with that force. Each row counts by `weight`; 0 where all
/// weights are zero.
double share_supported(const Eigen::VectorXd& claimed_N, const Eigen::VectorXd& left_N,
                       const Eigen::VectorXd& weight);

/// Whether the model has a ripple, other than the `known` terms, that traverses over whole pitches do not
/// support: all traverses, or those left when any one pitch of the rail is excluded. A force that repeats
/// along the rail shows wherever the axis moves. What fits only where the axis stands or creeps is something
/// else for which a pitch was found: friction that creeps there, drift in time, damage at one place.
bool ripple_not_supported(const Measurement& measurement, const FittedModel& model, const Terms& known);

}  // namespace slipstack::workbench
