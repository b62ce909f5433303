// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// Samples over which an effect is run at once: the basis of thirty gains then stays in the first-level
/// cache.
inline constexpr std::size_t kSampleChunk = 128;

/// Runs dry friction from sample `first` on, through the turning points that lie between samples: `values`
/// gets `width` numbers a sample. `unobserved` has room for those of one turning point, which are discarded.
template <class Runner>
void run_through_turning_points(const Measurement& measurement, Runner& runner, std::size_t first,
                                std::span<const Sample<double>> samples, std::size_t width, double* values,
                                double* unobserved) {
  std::size_t done = 0;
  for (const TurningPoint& turning_point : measurement.turning_points(first, samples.size())) {
    const std::size_t ahead = turning_point.before_sample - first;
    runner.run(samples.subspan(done, ahead - done), values + done * width);
    Sample<double> between = samples[ahead];
    between.displacement = turning_point.displacement_m;
    runner.run(std::span(&between, 1), unobserved);
    done = ahead;
  }
  runner.run(samples.subspan(done), values + done * width);
}

/// Runs one effect over one part of the measurement, from its reset state on, chunk by chunk: visit(first
/// sample, count, values). `runner`, an EffectBasis or an EffectForce, writes `width` numbers a sample.
/// `dry_N`: the sum of the dry forces at every sample, or empty where it is not known yet.
template <class Runner, class Visit>
void run_part(const Measurement& measurement, std::size_t part, Runner& runner, std::size_t width, bool dry,
              const std::vector<double>& dry_N, Visit&& visit) {
  std::vector<Sample<double>> samples(kSampleChunk);
  std::vector<double> values(kSampleChunk * std::max<std::size_t>(width, 1));
  std::vector<double> unobserved(std::max<std::size_t>(width, 1));
  const std::size_t begin = measurement.parts()[part].first_sample;
  const std::size_t end = measurement.parts()[part].end_sample();
  if (begin < end) runner.reset(measurement.sample(begin, part));
  for (std::size_t first = begin; first < end; first += kSampleChunk) {
    const std::size_t count = std::min(kSampleChunk, end - first);
    const auto own = std::span(samples).first(count);
    measurement.take_samples(part, first, own);
    if (!dry_N.empty()) {
      for (std::size_t i = 0; i < count; ++i) own[i].dry_friction_N = dry_N[first + i];
    }
    if (dry) {
      run_through_turning_points(measurement, runner, first, own, width, values.data(), unobserved.data());
    } else {
      runner.run(own, values.data());
    }
    visit(first, count, values.data());
  }
}

/// The same over all parts, with the basis of a term: visit(first sample, count, basis[sample][gain]).
template <class Visit>
void run_basis_of(const Measurement& measurement, const Term& term, const std::vector<double>& dry_N,
                  Visit&& visit) {
  const auto basis = term.effect->make();
  basis->prepare(term.shapes, {.tick_s = measurement.tick_s(), .metres_per_displacement = 1.0});
  for (std::size_t part = 0; part < measurement.parts().size(); ++part) {
    run_part(measurement, part, *basis, term.gains_per_set(), term.effect->acts_as(Acts::dry), dry_N, visit);
  }
}

}  // namespace slipstack::workbench
