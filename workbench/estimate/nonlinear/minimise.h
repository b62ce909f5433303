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

/// Bounded minimisation without derivatives (Nelder-Mead in NLopt; Nelder & Mead 1965, bounds after Box 1965)
/// from `start`, with at most `evaluations` calls of `cost` after the first. Returns the best shapes that
/// were evaluated, and their cost.
SearchResult refine_shapes(const std::vector<ShapeRange>& ranges, std::vector<double> start,
                           const std::function<double(const std::vector<double>&)>& cost, int evaluations);

}  // namespace slipstack::workbench
