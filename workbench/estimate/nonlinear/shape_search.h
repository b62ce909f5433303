// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/effects/effect_catalogue.h"

namespace slipstack::workbench {

/// One shape that is searched, and the range over which this log can show it.
struct ShapeRange {
  std::size_t index = 0;  ///< among the effect's shapes
  double lower = 0.0;
  double upper = 0.0;
  bool logarithmic = true;
  double first_step = 0.0;  ///< of the search; 0: a part of the range
  double nominal = 0.0;     ///< of nominal_shapes(): the value that it has until all else is known
};

/// `count` values strictly inside the range, evenly spaced.
std::vector<double> spread(const ShapeRange& range, std::size_t count);

/// Shapes of the effect that a search moves: bounds of the catalogue, narrowed to what the log can show
/// (no velocity above its fastest, no pitch longer than its stroke, no frequency beyond its bandwidth).
/// Grids and maps (slip distances, places) are set by default_shapes() and not searched.
std::vector<ShapeRange> searched_shapes(const Measurement& measurement, const EffectDescription& effect);

/// Shapes that keep their customary value until refine_nominal_shapes() (settle_customary.h):
/// exponents the middle of their bounds, a filter 0.
std::vector<ShapeRange> nominal_shapes(const Measurement& measurement, const EffectDescription& effect);

/// Starting values: see make_term().
std::vector<double> default_shapes(const Measurement& measurement, const EffectDescription& effect);

/// `count` slip distances for the identification, evenly spaced in logarithm.
std::vector<double> slip_distances(double shortest_m, double longest_m, std::size_t count,
                                   std::size_t capacity);

/// Points from which the search for an effect's shapes starts. `residual_N` (rows) suggests pitches and
/// frequencies; `force_N` (rows) those of ripples that scale with force.
std::vector<std::vector<double>> starting_shapes(const Measurement& measurement,
                                                 const EffectDescription& effect,
                                                 const Eigen::VectorXd& residual_N,
                                                 const Eigen::VectorXd& force_N);

/// Bounded minimisation without derivatives (NLopt's BOBYQA, or golden section's successor for one shape)
/// from `start`, at most `evaluations` calls. Returns the best shapes seen and their cost.
struct SearchResult {
  std::vector<double> shapes;
  double cost = 0.0;
};
SearchResult refine_shapes(const std::vector<ShapeRange>& ranges, std::vector<double> start,
                           const std::function<double(const std::vector<double>&)>& cost, int evaluations);

}  // namespace slipstack::workbench
