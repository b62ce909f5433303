// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// The change of a model's force at the rows [N] with each realisation of the encoder: the same motion as
/// read by encoders of equal resolution with shifted grids, each by another fraction of a step.
using ForceChanges = std::vector<Eigen::VectorXd>;

/// The changes of the force of each model. A realisation quantises the recorded motion again, with other
/// assumptions about the motion between readings, so the difference of the forces is the error of one
/// encoder. `at_once` realisations are in memory at a time; 0: one for each usable processor.
/// Cost: realisations x (samples + the evaluation of each model).
std::vector<ForceChanges> changes_by_quantisation_N(const Measurement& measurement,
                                                    const std::vector<const Terms*>& models,
                                                    std::size_t at_once);

/// The mean square, at the rows, of the force that the masses of each model (inertia, payload, mode) give on
/// what rounding makes of the motion [N^2]; zero without a resolution. This is what the rounding adds to the
/// mean square error of the model: a mass that does not follow at some frequencies lowers it there, whatever
/// the axis does. Cost: two realisations x (samples x the filter of the motion + the evaluation of the
/// masses).
std::vector<double> rounding_through_masses_N2(const Measurement& measurement,
                                               const std::vector<const Terms*>& models);

}  // namespace slipstack::workbench
