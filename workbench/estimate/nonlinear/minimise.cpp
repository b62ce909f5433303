// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/minimise.h"

#include <algorithm>
#include <cmath>
#include <nlopt.hpp>

namespace slipstack::workbench {
namespace {

/// In the coordinate of the search, in which the range has this length.
double first_step(const ShapeRange& range, double start, double length) {
  if (range.first_step > 0.0) return range.first_step;
  const double largest = range.logarithmic ? std::min(0.25, 0.25 * length) : 0.1 * length;
  const double step =
      range.repeats_over_m > 0.0 ? std::min(largest, 0.125 * start / range.repeats_over_m) : largest;
  return std::max(1e-12, step);
}

}  // namespace

SearchResult refine_shapes(const std::vector<ShapeRange>& ranges, std::vector<double> start,
                           const std::function<double(const std::vector<double>&)>& cost,
                           const SearchEffort& effort) {
  SearchResult best{start, cost(start)};
  if (ranges.empty() || effort.evaluations <= 0) return best;  // to NLopt, 0 is no limit
  const auto to_search = [&](const ShapeRange& range, double value) {
    return range.logarithmic ? std::log(value) : value;
  };
  std::vector<double> lower, upper, point, step;
  bool within = true;
  for (const ShapeRange& range : ranges) {
    lower.push_back(to_search(range, range.lower));
    upper.push_back(to_search(range, range.upper));
    const double wanted = to_search(range, start[range.index]);
    point.push_back(std::clamp(wanted, lower.back(), upper.back()));
    within = within && point.back() == wanted;
    step.push_back(first_step(range, start[range.index], upper.back() - lower.back()));
  }
  const std::vector<double> first = point;
  const double start_cost = best.cost;
  auto objective = [&](const std::vector<double>& x) {
    if (within && x == first) return start_cost;  // it is the start, but for the rounding of exp(log(x))
    std::vector<double> shapes = start;
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      shapes[ranges[i].index] = ranges[i].logarithmic ? std::exp(x[i]) : x[i];
    }
    const double value = cost(shapes);
    if (value < best.cost) best = {shapes, value};
    return value;
  };
  using Objective = decltype(objective);
  nlopt::opt search(nlopt::LN_NELDERMEAD, static_cast<unsigned>(ranges.size()));
  search.set_min_objective([](const std::vector<double>& x, std::vector<double>&,
                              void* data) { return (*static_cast<Objective*>(data))(x); },
                           &objective);
  search.set_lower_bounds(lower);
  search.set_upper_bounds(upper);
  search.set_initial_step(step);
  search.set_maxeval(effort.evaluations);
  search.set_ftol_rel(effort.tolerance);
  double value = best.cost;
  try {
    search.optimize(point, value);
  } catch (const nlopt::roundoff_limited&) {
    // No further progress in double precision: the best point found so far is the result.
  }
  return best;
}

}  // namespace slipstack::workbench
