// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/model/effect_adapters/firmware_effects.h"

namespace slipstack::workbench {

/// Points from which the search for the shapes of an effect starts. `residual_N` (rows) suggests pitches and
/// frequencies; for ripples that scale with the force, `force_N` (rows) is used too. `sample_force_N`: force
/// of the model at the samples, which see pitches that the axis passes too fast for the rows; empty: not
/// known.
std::vector<std::vector<double>> starting_shapes(const Measurement& measurement,
                                                 const EffectDescription& effect,
                                                 const Eigen::VectorXd& residual_N,
                                                 const Eigen::VectorXd& force_N,
                                                 const std::vector<double>& sample_force_N = {});

/// Of how many independent values of a shape the search takes the best: those of a pitch or a frequency that
/// the periodogram tells apart within the range; 1 of other shapes.
double independent_values(const Measurement& measurement, const EffectDescription& effect,
                          const ShapeRange& range);

}  // namespace slipstack::workbench
