// SPDX-License-Identifier: Apache-2.0
// Quasi-static hysteresis loops at stepped amplitude and several positions.
#pragma once

#include <cstdint>
#include <vector>

#include "sim_host/experiments/setup.h"

namespace slipstack::sim {

struct LoopRequest {
  bool by_force = false;           // a force sine, else a displacement sine
  std::vector<double> amplitudes;  // m, or N by force; rising
  std::vector<double> positions_m;
  double frequency_Hz = 1.0;
  std::size_t cycles = 10;    // averaged, after two that are discarded
  std::size_t samples = 200;  // of the averaged loop
  bool sensors = false;
  std::uint64_t seed = 1;
};

/// One averaged loop. Displacement from the loop's own middle, friction force without inertia.
struct MeasuredLoop {
  double position_m = 0.0;
  double asked = 0.0;  // requested amplitude
  std::vector<double> displacement_m;
  std::vector<double> force_N;
  double amplitude_m = 0.0;
  double force_amplitude_N = 0.0;  // half the height at the tips
  double area_J = 0.0;             // of the polygon
  double stiffness_N_per_m = 0.0;  // kₑ ≈ y(A)/A [2]
  double damping_N_per_m = 0.0;    // cₑ·ω = area/(π·A²)
  double damping_ratio = 0.0;      // ζᵣ = area/(2π·A·y(A))
  double closed_form_damping_ratio =
      0.0;               // of the set-up's virgin curve at this amplitude, preload map aside
  bool rolling = false;  // by force: the tips' tangent is below a twentieth of the first slope
};

/// All loops, position by position, one after another. With a displacement sine the motion is prescribed and
/// the drive force computed (inverse dynamics); with a force sine the axis moves (forward dynamics). The
/// force of inertia, known mass times acceleration of the sine, is subtracted; a cable chain, cogging and
/// similar forces remain: they are part of the measurement. Throws SetupError on amplitudes, positions or a
/// frequency that are not possible.
std::vector<MeasuredLoop> run_loops(const ExperimentSetup& setup, const LoopRequest& request);

/// The checks of run_loops() alone.
void check_loops(const ExperimentSetup& setup, const LoopRequest& request);

/// How many loops a request asks for, and one of them, from 0. Loops are independent of each other and may
/// be computed at the same time.
std::size_t loop_count(const LoopRequest& request);
MeasuredLoop measure_loop(const ExperimentSetup& setup, const LoopRequest& request, std::size_t index);

/// Fills the figures of a loop from its displacement and force.
void evaluate_loop(MeasuredLoop& loop);

}  // namespace slipstack::sim
