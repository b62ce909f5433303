// SPDX-License-Identifier: Apache-2.0
#include "workbench/cleaning/impacts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "workbench/base/statistics.h"
#include "workbench/cleaning/interpolate.h"

namespace slipstack::workbench {
namespace {

/// Of five pulses three lie in a tenth of the time by chance with a probability of 0.9 %, of more fewer.
constexpr std::size_t kFewestImpacts = 5;
/// Share of the time that counts as near to the changes of sign. Chosen.
constexpr double kNearShare = 0.1;
/// A change of sign counts when the force exceeds this share of its rms: noise at standstill has many. The
/// same as for load reversals of a model (LoadReversals).
constexpr double kClearSign = 0.1;

/// Samples from each sample to the nearest change of sign of the force, before or after it; infinite without
/// any.
std::vector<double> distances_to_reversals(const std::vector<double>& force_N) {
  const double clear_N = kClearSign * rms(force_N);
  std::vector<double> distances(force_N.size(), std::numeric_limits<double>::infinity());
  double side = 0.0;
  for (std::size_t i = 0; i < force_N.size(); ++i) {
    if (i > 0) distances[i] = distances[i - 1] + 1.0;
    if (std::abs(force_N[i]) < clear_N) continue;
    const double now = force_N[i] > 0.0 ? 1.0 : -1.0;
    if (side != 0.0 && now != side) distances[i] = 0.0;
    side = now;
  }
  for (std::size_t i = force_N.size() - 1; i > 0; --i)
    distances[i - 1] = std::min(distances[i - 1], distances[i] + 1.0);
  return distances;
}

}  // namespace

bool are_impacts(const Log& log, const std::vector<Interval>& pulses) {
  if (pulses.size() < kFewestImpacts) return false;
  std::vector<double> force_N = log.force_N;
  for (const Interval& pulse : pulses) interpolate(force_N, pulse);
  const std::vector<double> distances = distances_to_reversals(force_N);
  const double near = quantile(distances, kNearShare);
  const auto is_near = [near](double distance) { return distance <= near; };
  // Distances are whole samples: more of them than a tenth may be the same.
  const auto near_samples = static_cast<double>(std::count_if(distances.begin(), distances.end(), is_near));
  if (near_samples > 2.0 * kNearShare * static_cast<double>(distances.size())) return false;
  const auto impacts = static_cast<std::size_t>(std::count_if(
      pulses.begin(), pulses.end(), [&](const Interval& pulse) { return is_near(distances[pulse.first]); }));
  return 2 * impacts > pulses.size();
}

}  // namespace slipstack::workbench
