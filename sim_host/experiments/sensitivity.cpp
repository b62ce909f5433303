// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/sensitivity.h"

#include <fmt/format.h>

namespace slipstack::sim {

ExperimentSetup with_level(const ExperimentSetup& setup, double share) {
  ExperimentSetup changed = setup;
  std::vector<CurveTerm> terms = setup.axis.curve.terms();
  const double factor = 1.0 + share;
  for (CurveTerm& term : terms) {
    term.level_N *= factor;
    term.length_m *= factor;
    for (double& point_m : term.points_m) point_m *= factor;
    for (double& point_N : term.points_N) point_N *= factor;
  }
  changed.axis.curve = VirginCurve(std::move(terms));
  changed.text += fmt::format("\nlevel changed by {}", share);
  return changed;
}

std::vector<SensitivityPoint> sensitivity(const std::vector<SweepChain>& plain,
                                          const std::vector<SweepChain>& raised,
                                          const std::vector<SweepChain>& lowered, double share) {
  std::vector<SensitivityPoint> out;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const double force_N = plain[i].force_N;
    for (std::size_t k = 0; k < plain[i].sweeps.front().points.size(); ++k) {
      const SinePoint& here = plain[i].sweeps.front().points[k];
      const auto g = here.response_m_per_N(force_N);
      const auto up = raised[i].sweeps.front().points[k].response_m_per_N(force_N);
      const auto down = lowered[i].sweeps.front().points[k].response_m_per_N(force_N);
      const double spread = std::abs(up - down) / std::abs(g);
      out.push_back({force_N, here.frequency_Hz, std::abs(g), spread, spread / (2.0 * share)});
    }
  }
  return out;
}

}  // namespace slipstack::sim
