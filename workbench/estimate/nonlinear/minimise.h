// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "workbench/estimate/terms/search_ranges.h"

namespace slipstack::workbench {

struct SearchResult {
  std::vector<double> shapes;
  double cost = 0.0;
};

/// How much work a search may spend.
struct SearchEffort {
  int evaluations = 40;     ///< of the cost, in the refinement; 0: starting points only
  double tolerance = 1e-5;  ///< relative difference of the costs around the minimum that ends the search
};

/// Bounded minimisation without derivatives (Nelder-Mead in NLopt; Nelder & Mead 1965, bounds after Box 1965)
/// from `start`, with at most `effort.evaluations` calls of `cost` after the first. Returns the best shapes
/// that were evaluated, and their cost.
SearchResult refine_shapes(const std::vector<ShapeRange>& ranges, std::vector<double> start,
                           const std::function<double(const std::vector<double>&)>& cost,
                           const SearchEffort& effort);

}  // namespace slipstack::workbench
