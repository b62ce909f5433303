// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// Rows on the way of strokes that are at least `length_m` long: how far the axis goes there, m; else zero.
/// A stroke ends where the axis has come back by a tenth of `length_m`. Logs are strokes of their own; rows
/// that see what mend() cut count nothing.
Eigen::VectorXd distance_in_traverses(const Measurement& measurement, double length_m);

/// Of the force `claimed_N`, how much the axis shows: 1 all, 0 nothing, below zero the opposite. `left_N` is
/// what the model with that force leaves; every row counts by `weight`. 0 where no row counts.
double share_supported(const Eigen::VectorXd& claimed_N, const Eigen::VectorXd& left_N,
                       const Eigen::VectorXd& weight);

/// Whether the model has a ripple, which is none of the `known` terms, that strokes over whole pitches do not
/// bear out, all of them or with any one pitch of the rail left out. What repeats along the rail shows
/// wherever the axis goes; what only fits the places where it rests or creeps is something else, which a
/// pitch was found for: a friction force that creeps there, a wander in time, a dent.
bool ripple_not_supported(const Measurement& measurement, const FittedModel& model, const Terms& known);

}  // namespace slipstack::workbench
