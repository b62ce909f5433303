// SPDX-License-Identifier: Apache-2.0
#include "workbench/simulate/run_intervals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "workbench/base/errors.h"
#include "workbench/base/statistics.h"
#include "workbench/base/text.h"
#include "workbench/estimate/measurement/conditioning.h"
#include "workbench/signal/zero_phase.h"

namespace slipstack::workbench {
namespace {

/// Shorter runs say more of their initial state than of the model. Chosen.
constexpr double kShortestRun_s = 0.2;

/// Whether what an effect does depends on what the axis did before.
bool has_memory(const Terms& terms) {
  return has_role(terms, Role::hysteresis) || has_role(terms, Role::friction_memory) ||
         has_role(terms, Role::resonance);
}

}  // namespace

std::vector<FreeRunInterval> run_intervals(const std::string& logs, const Measurement& measurement,
                                           const Terms& terms, double horizon_s) {
  const bool memory = has_memory(terms);
  const double rate_Hz = measurement.sample_rate_Hz();
  const auto shortest = static_cast<std::size_t>(std::ceil(kShortestRun_s * rate_Hz));
  std::vector<FreeRunInterval> whole;
  std::size_t samples = 0;
  for (std::size_t p = 0; p < measurement.parts().size(); ++p) {
    const LogPart& part = measurement.parts()[p];
    // At the very start of a part the filters see repeated samples, and the velocity is not known.
    const std::size_t known = std::max(measurement.margin(), memory ? part.burn_in : 0);
    for (const Interval& one : usable_intervals(part, known)) {
      if (one.size() < shortest) continue;
      whole.push_back({p, part.first_sample, part.first_sample + one.first, part.first_sample + one.end});
      samples += one.size();
    }
  }
  const double wanted = std::min(horizon_s * rate_Hz, static_cast<double>(samples) / kLeastRuns);
  std::vector<FreeRunInterval> runs;
  for (const FreeRunInterval& one : whole) {
    const auto count =
        static_cast<std::size_t>(std::max(1.0, std::round(static_cast<double>(one.size()) / wanted)));
    if (one.size() / count < shortest) continue;
    const LogPart& part = measurement.parts()[one.part];
    const std::size_t known = std::max(part.burn_in, settling_samples(rate_Hz));
    for (std::size_t k = 0; k < count; ++k) {
      FreeRunInterval run = one;
      run.first = one.first + k * one.size() / count;
      run.end = one.first + (k + 1) * one.size() / count;
      run.warm_up = memory ? std::max(part.first_sample, run.first - std::min(run.first, known)) : run.first;
      runs.push_back(run);
    }
  }
  if (runs.size() < kLeastRuns) {
    throw InputError(fmt::format(
        "{}: --criterion simulation needs at least {} runs of {} s without a gap to fit and to judge; give a "
        "longer log without gaps, or fit by inverse dynamics",
        printable(logs), kLeastRuns, kShortestRun_s));
  }
  return runs;
}

std::vector<FreeRunInterval> joined_runs(const std::vector<FreeRunInterval>& runs) {
  std::vector<FreeRunInterval> joined;
  for (const FreeRunInterval& run : runs) {
    if (!joined.empty() && joined.back().part == run.part && joined.back().end == run.first) {
      joined.back().end = run.end;
    } else {
      joined.push_back(run);
    }
  }
  return joined;
}

InitialState initial_state_deviation(const Measurement& measurement) {
  double squares_m2 = 0.0;
  for (std::size_t i = 0; i < measurement.sample_count(); ++i) {
    squares_m2 += squared(measurement.log().position_m[i] - measurement.position_m()[i]);
  }
  constexpr double kLeast_m = 1e-12;  // a log without noise
  const double position_m =
      std::max(kLeast_m, std::sqrt(squares_m2 / static_cast<double>(measurement.sample_count())));
  // White up to a bandwidth, the derivative has 2 pi times the bandwidth over sqrt(3) times the deviation.
  const std::vector<double> taps = motion_taps(measurement.bandwidth_Hz(), measurement.sample_rate_Hz());
  const double bandwidth_Hz = 0.5 * noise_gain(taps) * measurement.sample_rate_Hz();
  return {position_m, position_m * 2.0 * std::numbers::pi * bandwidth_Hz / std::sqrt(3.0)};
}

}  // namespace slipstack::workbench
