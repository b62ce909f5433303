// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/composition.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// The dry friction of a model at every sample of a log, and what modulates it.
struct DryTrace {
  std::vector<double> dry_N;                    ///< sum of `dry`, not modulated
  std::vector<std::vector<double>> dry_scales;  ///< 1 + modulation, per term; empty where it has none
  std::vector<double> dry_factor;               ///< product of dry_scales; empty means one
};

/// The force of a model at every sample of a log, by the firmware's basis functions.
struct ForceTrace : DryTrace {
  std::vector<std::vector<double>> total_scales;  ///< 1 + modulation of the whole force, as dry_scales
  std::vector<double> total_factor;               ///< product of total_scales; empty means one
  std::vector<double> force_N;
};

/// The value of a factor, of which an empty one means one everywhere.
inline double factor_at(const std::vector<double>& factor, std::size_t sample) {
  return factor.empty() ? 1.0 : factor[sample];
}

/// Whether a term has gains that act so.
bool acts_with_gains(const Term& term, Acts acts);

/// Adds what the gains of a term that act so contribute at every sample, gain x basis, to `sum`. `dry_N` as
/// for run_part().
void add_contribution(const Measurement& measurement, const Term& term, Acts acts,
                      const std::vector<double>& dry_N, std::vector<double>& sum);

/// Dry friction and its modulation. `dry_N`, the sum of the dry forces where it is known, saves evaluating
/// them; the hysteresis costs most.
DryTrace evaluate_dry(const Measurement& measurement, const Terms& terms,
                      const std::vector<double>* dry_N = nullptr);

/// The whole force, from its dry friction.
ForceTrace evaluate_force(const Measurement& measurement, const Terms& terms, DryTrace dry);
inline ForceTrace evaluate_force(const Measurement& measurement, const Terms& terms) {
  return evaluate_force(measurement, terms, evaluate_dry(measurement, terms));
}

}  // namespace slipstack::workbench
