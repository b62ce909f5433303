// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/linear/force_trace.h"

#include <algorithm>
#include <utility>

#include "workbench/base/parallel.h"
#include "workbench/estimate/linear/run_effect.h"

namespace slipstack::workbench {
namespace {

void multiply(std::vector<double>& product, const std::vector<double>& factor) {
  if (factor.empty()) return;
  if (product.empty()) {
    product = factor;
    return;
  }
  for (std::size_t i = 0; i < product.size(); ++i) product[i] *= factor[i];
}

/// One set of a term's gains, with those that act otherwise zero.
std::vector<double> gains_that_act(const Term& term, Acts acts, std::size_t set) {
  const double* const own = term.gains.data() + set * term.gains_per_set();
  std::vector<double> gains(term.gains_per_set(), 0.0);
  std::size_t gain = 0;
  for (const GainGroup& group : term.effect->gain_groups) {
    const auto end = gain + static_cast<std::size_t>(group.count);
    for (; gain < end; ++gain) {
      if (group.acts == acts) gains[gain] = own[gain];
    }
  }
  return gains;
}

/// 1 + the modulation by each term that acts so.
std::vector<std::vector<double>> scales_of(const Measurement& measurement, const Terms& terms, Acts acts,
                                           const std::vector<double>& dry_N) {
  std::vector<std::vector<double>> scales(terms.size());
  for (std::size_t t = 0; t < terms.size(); ++t) {
    if (!acts_with_gains(terms[t], acts)) continue;
    scales[t].assign(measurement.sample_count(), 1.0);
    add_contribution(measurement, terms[t], acts, dry_N, scales[t]);
  }
  return scales;
}

}  // namespace

bool acts_with_gains(const Term& term, Acts acts) {
  return !term.gains.empty() && term.effect->acts_as(acts);
}

void add_contribution(const Measurement& measurement, const Term& term, Acts acts,
                      const std::vector<double>& dry_N, std::vector<double>& sum) {
  const Scales<double> scales{.tick_s = measurement.tick_s(), .metres_per_displacement = 1.0};
  parallel_for(measurement.parts().size(), [&](std::size_t part) {
    const std::size_t set = term.gain_sets() > 1 ? measurement.parts()[part].log : 0;
    const std::vector<double> gains = gains_that_act(term, acts, set);
    if (std::all_of(gains.begin(), gains.end(), [](double gain) { return gain == 0.0; })) return;
    const auto force = term.effect->make_force(term.shapes, gains, scales);
    run_part(measurement, part, *force, 1, term.effect->acts_as(Acts::dry), dry_N,
             [&](std::size_t first, std::size_t count, const double* values) {
               for (std::size_t i = 0; i < count; ++i) sum[first + i] += values[i];
             });
  });
}

DryTrace evaluate_dry(const Measurement& measurement, const Terms& terms, const std::vector<double>* dry_N) {
  DryTrace dry;
  if (dry_N != nullptr) {
    dry.dry_N = *dry_N;
  } else {
    dry.dry_N.assign(measurement.sample_count(), 0.0);
    for (const Term& term : terms) {
      if (acts_with_gains(term, Acts::dry)) add_contribution(measurement, term, Acts::dry, {}, dry.dry_N);
    }
  }
  dry.dry_scales = scales_of(measurement, terms, Acts::dry_scale, dry.dry_N);
  for (const auto& scale : dry.dry_scales) multiply(dry.dry_factor, scale);
  return dry;
}

ForceTrace evaluate_force(const Measurement& measurement, const Terms& terms, DryTrace dry) {
  ForceTrace trace;
  static_cast<DryTrace&>(trace) = std::move(dry);
  trace.force_N.assign(measurement.sample_count(), 0.0);
  for (const Term& term : terms) {
    if (acts_with_gains(term, Acts::force))
      add_contribution(measurement, term, Acts::force, trace.dry_N, trace.force_N);
  }
  trace.total_scales = scales_of(measurement, terms, Acts::total_scale, trace.dry_N);
  for (const auto& scale : trace.total_scales) multiply(trace.total_factor, scale);
  for (std::size_t i = 0; i < trace.force_N.size(); ++i) {
    trace.force_N[i] = composed_friction_N(trace.force_N[i], trace.dry_N[i], factor_at(trace.dry_factor, i)) *
                       factor_at(trace.total_factor, i);
  }
  return trace;
}

}  // namespace slipstack::workbench
