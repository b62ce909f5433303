// SPDX-License-Identifier: Apache-2.0
#include "sim_host/sensors/encoder.h"

#include <cmath>

namespace slipstack::sim {

std::int64_t Encoder::counts(double position_m, double t_s) const {
  double count = position_m / resolution_m_ + phase_;
  for (const EncoderSlip::Loss& loss : slip_.losses) {
    if (t_s >= loss.time_s) count -= loss.counts;
  }
  return static_cast<std::int64_t>(std::floor(count + 0.5));
}

double Encoder::position_m(double position_m, double t_s) const {
  if (!(resolution_m_ > 0.0)) return position_m;
  return static_cast<double>(counts(position_m, t_s)) * resolution_m_;
}

}  // namespace slipstack::sim
