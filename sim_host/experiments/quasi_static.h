// SPDX-License-Identifier: Apache-2.0
// A slow sine of force on a guideway, as [2] measures: amplitude raised step by step until rolling begins.
#pragma once

#include <cstdint>
#include <vector>

#include "sim_host/plant/friction/maxwell_elements.h"

namespace slipstack::sim {

struct QuasiStaticTest {
  double frequency_Hz = 1.0;
  std::size_t cycles = 12;       // per amplitude; the first carries the way there
  std::vector<double> forces_N;  // amplitudes, rising
  double sample_rate_Hz = 1000.0;
  double encoder_resolution_m = 0.0;
  double force_noise_N = 0.0;
  std::uint64_t seed = 1;
};

struct QuasiStaticRecord {
  std::vector<double> time_s;
  std::vector<double> position_m;
  std::vector<double> force_N;
};

/// What a laboratory would record of a force so slow that inertia does not count: the elements carry it, so
/// their place follows, exactly. Position is rounded to the encoder's step, force carries white noise. Force
/// goes from one amplitude to the next at a zero crossing. Cost: about 0.1 µs for every sample and every
/// element that begins to slip.
/// Throws std::invalid_argument when a force is not positive, or reaches the saturation of the elements: the
/// axis would roll away.
QuasiStaticRecord record_loops(const MaxwellElements& bank, const QuasiStaticTest& test);

/// Elements of a virgin curve that are fine where loops of these amplitudes are drawn: slip distances from
/// 1/30 of the smallest to three times the largest amplitude. MaxwellElements::sample(curve, count) spreads
/// them over the whole travel. Throws std::invalid_argument when the amplitudes are not positive.
MaxwellElements elements_between(const VirginCurve& curve, double smallest_m, double largest_m,
                                 std::size_t count = 200);

/// Moves the bank to where it carries a force; |force| below its saturation. One step per element that begins
/// to slip.
void move_to_force(MaxwellElements& bank, double force_N);

/// Force amplitudes up to the onset of rolling: `count` of them, the displacement amplitudes geometric
/// between the two given. Throws std::invalid_argument when they are not positive and rising.
std::vector<double> forces_for(const VirginCurve& curve, double smallest_m, double largest_m,
                               std::size_t count);

}  // namespace slipstack::sim
