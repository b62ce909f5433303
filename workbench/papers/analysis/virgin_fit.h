// SPDX-License-Identifier: Apache-2.0
// Virgin curves from measured loops, and from given damping ratios.
#pragma once

#include <span>
#include <vector>

#include "sim_host/plant/friction/virgin_curve.h"
#include "workbench/papers/analysis/loop_figures.h"

namespace slipstack::workbench {

/// A virgin curve as a polygon from the origin, which is a sum of Maxwell elements. Rising and concave;
/// constant after its last point.
struct PolygonCurve {
  std::vector<double> displacement_m;  // positive, increasing
  std::vector<double> force_N;

  double force_at_N(double displacement) const;
  double initial_stiffness_N_per_m() const { return force_N.front() / displacement_m.front(); }
  double reach_m() const { return displacement_m.back(); }
};

/// A point of the virgin curve from a loop: by Masing's rule each branch is −Fm + 2·y((x + A)/2).
struct VirginSample {
  double displacement_m = 0.0;
  double force_N = 0.0;
};
std::vector<VirginSample> virgin_samples(const Loop& loop);

/// A fitted curve and its error: root mean square over the largest force.
struct RationalFit {
  RationalCurve curve;
  double relative_error = 0.0;
};

/// h₀ and δ of [2], eq. 14, from loops by least squares: h₀ is linear, δ is searched for from 1/1000 to 1000
/// of the largest amplitude. Throws std::invalid_argument when there is no loop.
RationalFit fit_rational(std::span<const Loop> loops);

struct PolygonFit {
  PolygonCurve curve;
  double relative_error = 0.0;
};

/// The concave curve of at most `elements` corners nearest to a loop: Maxwell elements at geometrically
/// spaced slip distances, stiffnesses by non-negative least squares. Throws std::invalid_argument when the
/// loop is not that of a concave curve: the nearest one is off by more than 5 % of the force.
PolygonFit fit_polygon(const Loop& loop, std::size_t elements = 40);

/// A given damping ratio at an amplitude.
struct DampingPoint {
  double amplitude_m = 0.0;
  double damping_ratio = 0.0;
};

/// A virgin curve whose ζᵣ passes near the given points: a sum of rational terms at lengths from 1/30 of the
/// smallest to 300 times the largest amplitude. E(A) − ζ·2π·A·y(A) = 0 is linear in the levels of the terms,
/// so they come from non-negative least squares, scaled to `force_N` at the largest amplitude. Throws
/// std::invalid_argument when a point is not positive or none is given.
sim::VirginCurve curve_of_damping(const std::vector<DampingPoint>& points, double force_N);

}  // namespace slipstack::workbench
