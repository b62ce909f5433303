// SPDX-License-Identifier: Apache-2.0
// Delay of a signal: fractional delay and first-order filter.
#pragma once

#include <cstddef>
#include <vector>

namespace slipstack::sim {

/// Delays a uniformly sampled signal by any fraction of a step (third-order Lagrange interpolation), then
/// filters it by a first-order lag (exact for a signal that is linear between samples). Before the first
/// sample the signal is assumed to be equal to it.
class DelayLine {
 public:
  /// Throws std::invalid_argument unless step > 0 and neither time is negative.
  DelayLine(double step_s, double delay_s, double filter_s);
  /// Takes the next sample, returns the delayed one.
  double push(double value);

 private:
  double tap(std::size_t steps_ago) const;

  std::size_t whole_;
  double fraction_;
  double decay_;
  double ramp_;  // weight of the newest sample in the exact response to a ramp
  std::vector<double> ring_;
  std::size_t newest_ = 0;
  bool filled_ = false;
  double delayed_ = 0.0;
  double filtered_ = 0.0;
};

}  // namespace slipstack::sim
