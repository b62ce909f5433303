// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim_host/log/draw.h"
#include "sim_host/log/record.h"
#include "sim_host/plant/friction/maxwell_elements.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench::test {

/// The log that a user of this axis would have.
inline Log log_of(const sim::Axis& axis, const sim::SimulatedLog& simulated) {
  Log log;
  log.path = "simulated";
  log.sample_rate_Hz = simulated.rate_Hz;
  log.position_m = simulated.position_m;
  log.force_N = simulated.force_N;
  log.reference_position_m = simulated.reference_position_m;
  log.mass_kg = axis.mass_kg;
  log.magnet_pitch_m = axis.magnet_pitch_m;
  if (axis.encoder_resolution_m > 0.0) log.encoder_resolution_m = axis.encoder_resolution_m;
  return log;
}

/// An axis of mass and hysteresis, recorded over the usual programme.
inline Log simulate(const sim::Bench& bench, std::uint64_t seed) {
  const sim::MotionProgramme programme = sim::draw_programme(bench, seed);
  return log_of(bench.axis, sim::simulate_log(bench.axis, programme, bench.rate_Hz, seed));
}

/// The true model of that axis as terms of the workbench: its mass and the elements of its hysteresis.
inline Terms truth_of(const Measurement& measurement, const sim::Axis& axis) {
  const sim::MaxwellElements bank = sim::MaxwellElements::sample(axis.curve, axis.elements);
  Terms terms{make_term(measurement, *find_effect("inertia")),
              make_term(measurement, *find_effect("presliding_hysteresis"))};
  terms[0].gains[0] = axis.mass_kg;
  for (std::size_t i = 0; i < terms[1].gains.size(); ++i) {
    terms[1].shapes[i] = i < bank.size() ? bank.slip_m(i) : 0.0;
    terms[1].gains[i] = i < bank.size() ? bank.stiffness_N_per_m(i) : 0.0;
  }
  return terms;
}

}  // namespace slipstack::workbench::test
