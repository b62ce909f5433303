// SPDX-License-Identifier: Apache-2.0
#include "sim_host/sensors/low_pass.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim_host/turn.h"

namespace slipstack::sim {
namespace {

/// One pair of poles over the whole signal; `damping` is the sine of their angle from the imaginary axis.
void pass_pair(std::vector<double>& signal, double tangent, double damping) {
  // Of x = w + 2 w' + w'', with w the state one and two samples ago; gain 1 at rest.
  const double scale = 1.0 / (1.0 + 2.0 * damping * tangent + tangent * tangent);
  const double gain = tangent * tangent * scale;
  const double first = 2.0 * (tangent * tangent - 1.0) * scale;
  const double second = (1.0 - 2.0 * damping * tangent + tangent * tangent) * scale;
  double once = signal.front() / (1.0 + first + second);
  double twice = once;
  for (double& value : signal) {
    const double state = value - first * once - second * twice;
    value = gain * (state + 2.0 * once + twice);
    twice = once;
    once = state;
  }
}

}  // namespace

std::vector<double> low_passed(std::vector<double> signal, double rate_Hz, double cut_Hz, int order,
                               bool zero_phase) {
  if (order <= 0 || order % 2 != 0 || !(cut_Hz > 0.0 && cut_Hz < 0.5 * rate_Hz)) {
    throw std::invalid_argument("low pass: the order must be even, the cut below half of the rate");
  }
  if (signal.empty()) return signal;
  const double tangent = std::tan(0.5 * kTurn * cut_Hz / rate_Hz);
  for (int pass = 0; pass < (zero_phase ? 2 : 1); ++pass) {
    for (int pair = 0; pair < order / 2; ++pair)
      pass_pair(signal, tangent, std::sin(0.25 * kTurn * (2 * pair + 1) / order));
    if (zero_phase) std::reverse(signal.begin(), signal.end());
  }
  return signal;
}

}  // namespace slipstack::sim
