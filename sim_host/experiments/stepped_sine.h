// SPDX-License-Identifier: Apache-2.0
// Frequency responses as they are measured: sines of stepped frequency, up and down, at given force levels.
#pragma once

#include <complex>
#include <cstdint>
#include <string>
#include <vector>

#include "sim_host/experiments/setup.h"
#include "sim_host/experiments/sweep.h"

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

/// All sweeps. The axis starts at rest and relaxed at the set-up's position for each force level; between
/// frequencies and sweeps of a level it goes on as it is, the sine without a step. Each frequency is held
/// until the geometric series of the changes of the fundamental from period to period leaves less than
/// `settled`, twice in a row, and at least four periods; a point that has not settled after most_periods is
/// marked.
///
/// A jump: the amplitude changes from one frequency to the next by more than a factor 1.5, and when the same
/// way is gone in eight smaller steps (on a copy of the axis), most of the change still happens in one of
/// them. A resonance that is merely steep spreads its change over them.
///
/// `chains` holds what a stopped run left (or nothing); it is carried on. Force levels are independent
/// pieces: the result does not depend on the number of threads, nor on where it was stopped, bit for bit.
/// Throws SetupError when a force is not positive, beyond the drive, or too small to be seen by the sensors,
/// or a frequency is not positive or not below half the sampling rate.
void run_stepped_sine(const ExperimentSetup& setup, const SteppedSineRequest& request,
                      std::vector<SweepChain>& chains, const Watch& watch);

/// The checks of run_stepped_sine() alone.
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
