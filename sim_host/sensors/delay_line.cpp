// SPDX-License-Identifier: Apache-2.0
#include "sim_host/sensors/delay_line.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace slipstack::sim {

DelayLine::DelayLine(double step_s, double delay_s, double filter_s) {
  if (!(step_s > 0.0) || !(delay_s >= 0.0) || !(filter_s >= 0.0)) {
    throw std::invalid_argument("delay line: times must not be negative");
  }
  const double steps = delay_s / step_s;
  whole_ = static_cast<std::size_t>(steps);
  fraction_ = steps - static_cast<double>(whole_);
  decay_ = filter_s > 0.0 ? std::exp(-step_s / filter_s) : 0.0;
  ramp_ = filter_s > 0.0 ? 1.0 - (1.0 - decay_) * filter_s / step_s : 1.0;
  ring_.assign(whole_ + 4, 0.0);
}

double DelayLine::tap(std::size_t steps_ago) const {
  return ring_[(newest_ + ring_.size() - steps_ago) % ring_.size()];
}

double DelayLine::push(double value) {
  if (!filled_) {
    std::fill(ring_.begin(), ring_.end(), value);
    delayed_ = filtered_ = value;
    filled_ = true;
  }
  newest_ = (newest_ + 1) % ring_.size();
  ring_[newest_] = value;

  // Lagrange through four neighbours; the first four serve the fraction of the first step, where no later
  // sample is known.
  const std::size_t first = whole_ > 0 ? whole_ - 1 : 0;
  const double d = fraction_ + static_cast<double>(whole_ - first);
  const double y0 = tap(first);
  const double y1 = tap(first + 1);
  const double y2 = tap(first + 2);
  const double y3 = tap(first + 3);
  const double late = -y0 * (d - 1.0) * (d - 2.0) * (d - 3.0) / 6.0 + y1 * d * (d - 2.0) * (d - 3.0) / 2.0 -
                      y2 * d * (d - 1.0) * (d - 3.0) / 2.0 + y3 * d * (d - 1.0) * (d - 2.0) / 6.0;
  // Exact response of a first-order lag to the straight line from the last delayed sample to this one.
  filtered_ = decay_ * filtered_ + (1.0 - decay_ - ramp_) * delayed_ + ramp_ * late;
  delayed_ = late;
  return filtered_;
}

}  // namespace slipstack::sim
