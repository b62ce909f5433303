// SPDX-License-Identifier: Apache-2.0
// Frequency responses as they are measured: sines of stepped frequency, up and down, at given force levels.
#pragma once

#include <atomic>
#include <complex>
#include <cstdint>
#include <functional>
#include <vector>

#include "sim_host/experiments/setup.h"

namespace slipstack::sim {

struct SteppedSineRequest {
  std::vector<double> forces_N;
  std::vector<double> frequencies_Hz;  // rising
  bool up = true;
  bool down = false;
  std::size_t repeats = 1;  // of up, down, or up and down, one after the other
  double tolerance = 1e-7;  // of the integration
  double settled = 1e-4;    // change of the fundamental that is left to come, over the fundamental
  std::size_t most_periods = 400;
  bool sensors = false;    // through encoder, noise, filter and delay of the set-up
  std::uint64_t seed = 1;  // of the noise
};

struct SinePoint {
  double frequency_Hz = 0.0;
  double amplitude_m = 0.0;  // fundamental of the displacement
  double phase_rad = 0.0;    // against the force
  double mean_m = 0.0;       // of the position over the last period
  double periods = 0.0;
  bool settled = false;
  bool jump = false;  // between this point and the one measured before it

  std::complex<double> response_m_per_N(double force_N) const {
    return std::polar(amplitude_m / force_N, phase_rad);
  }
};

/// One sweep; points in the order in which they were measured.
struct Sweep {
  double force_N = 0.0;
  bool up = true;
  std::size_t repeat = 0;
  std::vector<SinePoint> points;
};

/// Sweeps of one force level, one after the other on the same axis: what is left when a run is stopped.
struct SweepChain {
  double force_N = 0.0;
  std::vector<Sweep> sweeps;
  std::vector<double> state;  // SmoothAxis::snapshot() after the last point
  bool complete = false;
};

/// How the caller follows a long run and ends it early; both may be left empty.
struct SweepControl {
  std::function<void()> point_done = {};    // called after each point
  const std::atomic<bool>* stop = nullptr;  // when set, the run ends before the next point
};

/// Sweeps at all force levels, one level after another. The axis starts at rest and relaxed at the set-up's
/// position for each force level; between frequencies and sweeps of a level its state is kept and the phase
/// of the sine is continuous. Each frequency is held until the geometric series of the changes of the
/// fundamental from period to period leaves less than `settled`, twice in a row, and at least four periods; a
/// point that has not settled after most_periods is marked.
///
/// A jump: the amplitude changes from one frequency to the next by more than a factor 1.5, and when the
/// interval between them is divided into eight smaller steps (on a copy of the axis), most of the change
/// still happens in one of them. A resonance that is merely steep spreads its change over them.
///
/// `chains` holds the result of a run that was stopped (or nothing) and is continued. The result is the same,
/// bit for bit, wherever a run was stopped. Throws SetupError when a force is not positive, beyond the drive,
/// or too small for the sensors, or a frequency is not positive or not below half the sampling rate.
void run_stepped_sine(const ExperimentSetup& setup, const SteppedSineRequest& request,
                      std::vector<SweepChain>& chains, const SweepControl& control = {});

/// The first part of run_stepped_sine(): checks the request, and gives `chains` an entry for each force
/// level.
void prepare_sweeps(const ExperimentSetup& setup, const SteppedSineRequest& request,
                    std::vector<SweepChain>& chains);

/// The second part of run_stepped_sine() for force level `index`, with `chain` its entry: nothing is done if
/// it is complete. Force levels are independent of each other and may run at the same time.
void run_sweep_chain(const ExperimentSetup& setup, const SteppedSineRequest& request, std::size_t index,
                     SweepChain& chain, const SweepControl& control = {});

/// Points of one force level when it is complete.
std::size_t points_per_level(const SteppedSineRequest& request);

/// The checks of prepare_sweeps() alone.
void check_stepped_sine(const ExperimentSetup& setup, const SteppedSineRequest& request);

/// `count` frequencies from low to high, evenly in the logarithm.
std::vector<double> log_frequencies(double low_Hz, double high_Hz, std::size_t count);

/// Where the amplitude of a sweep is largest: a parabola through the logarithms around the largest point; the
/// first or last frequency when it lies at an end.
struct Peak {
  double frequency_Hz = 0.0;
  double amplitude_m = 0.0;
  bool inside = false;
};
Peak peak_of(const Sweep& sweep);

}  // namespace slipstack::sim
