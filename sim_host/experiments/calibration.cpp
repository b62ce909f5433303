// SPDX-License-Identifier: Apache-2.0
#include "sim_host/experiments/calibration.h"

#include <functional>

#include "sim_host/experiments/quasi_static.h"
#include "sim_host/rng.h"

namespace slipstack::sim {
namespace {

/// Takes a load after a wait and reads the transducer.
using Reader = std::function<LoadStep(double load_N, double wait_s)>;

/// Preloads, then up and down with a loop between 22 and 8 % of full scale on either way.
std::vector<LoadStep> cycle_with_loops(const TransducerSetup& setup, const Reader& read) {
  const double full_N = setup.full_scale_N;
  const auto level = [&](std::size_t i) {
    return full_N * static_cast<double>(i) / static_cast<double>(setup.steps);
  };
  std::vector<LoadStep> record;
  record.push_back(read(0.0, setup.preload_s));
  for (std::size_t i = 0; i < setup.preloads; ++i) {
    record.push_back(read(full_N, setup.preload_s));
    record.push_back(read(0.0, setup.preload_s));
  }
  // Down from 22 % to 8 % and up again, or the other way round, in steps of 2 %.
  const auto way = [&](int from_percent, int to_percent) {
    const int by = from_percent < to_percent ? 2 : -2;
    for (int p = from_percent + by; p != to_percent + by; p += by) {
      record.push_back(read(0.01 * p * full_N, setup.step_s));
    }
  };
  for (std::size_t i = 1; i <= setup.steps; ++i) {
    if (level(i - 1) < 0.22 * full_N && level(i) >= 0.22 * full_N) {
      record.push_back(read(0.22 * full_N, setup.step_s));
      way(22, 8);
      way(8, 22);
    }
    if (level(i) > 1.001 * record.back().load_N) record.push_back(read(level(i), setup.step_s));
  }
  for (std::size_t i = setup.steps; i-- > 0;) {
    if (level(i) < 0.08 * full_N && level(i + 1) >= 0.08 * full_N) {
      if (level(i + 1) > 0.081 * full_N) record.push_back(read(0.08 * full_N, setup.step_s));
      way(8, 22);
      way(22, 8);
    }
    record.push_back(read(level(i), setup.step_s));
  }
  return record;
}

}  // namespace

SimulatedCalibration simulate_calibration(const TransducerSetup& setup, std::uint64_t seed) {
  const double full_N = setup.full_scale_N;
  // Between a power law and an exponential: no sum of ten straight lines.
  const VirginCurve shape({{CurveKind::kStretched, 1.0, setup.hysteresis_length_N, 0.85}});
  // d_h of a cycle after preloads, halfway, is y(FS/4) + y(FS/4) − y(FS/2).
  const double middle = 2.0 * shape.force_N(0.25 * full_N) - shape.force_N(0.5 * full_N);
  const VirginCurve curve(
      {{CurveKind::kStretched, setup.hysteresis_mV_per_V / middle, setup.hysteresis_length_N, 0.85}});
  MaxwellElements bank = elements_between(curve, 0.06 * full_N, full_N);
  Rng noise(seed, "transducer");
  double time_s = 0.0;
  const auto read = [&](double load_N, double wait_s) {
    bank.move_to(load_N);
    time_s += wait_s;
    const double u = load_N / full_N;
    const double straight = setup.sensitivity_mV_per_V * u + setup.quadratic_mV_per_V * u * (1.0 - u) +
                            setup.cubic_mV_per_V * u * (1.0 - u) * (1.0 - 2.0 * u);
    return LoadStep{time_s, load_N,
                    straight + bank.force_N() + setup.zero_drift_mV_per_V_per_s * time_s +
                        setup.noise_mV_per_V * noise.normal()};
  };
  SimulatedCalibration result;
  const auto level = [&](std::size_t i) {
    return full_N * static_cast<double>(i) / static_cast<double>(setup.steps);
  };
  for (std::size_t i = 0; i <= setup.steps; ++i) result.virgin.push_back(read(level(i), setup.step_s));
  for (std::size_t i = setup.steps; i-- > 0;) result.virgin.push_back(read(level(i), setup.step_s));

  result.loops = cycle_with_loops(setup, read);
  result.repeat = cycle_with_loops(setup, read);
  return result;
}

}  // namespace slipstack::sim
