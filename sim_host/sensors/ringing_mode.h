// SPDX-License-Identifier: Apache-2.0
// A lightly damped mode in the path of the measured force.
#pragma once

namespace slipstack::sim {

/// A mass on a spring between the force and what is read of it: q″ + 2ζω q′ + ω² (q − F) = 0, q in N. Below
/// its frequency the reading follows the force; each kink of the force (jerk of a move, a reversal of the
/// friction) makes it ring. Exact for a force that is linear between samples. It begins at rest on the first
/// force.
class RingingMode {
 public:
  /// Throws std::invalid_argument unless the step and the frequency are positive and 0 ≤ damping ratio < 1.
  RingingMode(double step_s, double frequency_Hz, double damping_ratio);
  /// Takes the force of the next sample, returns by how much the reading differs from it, q − F, N.
  double push(double force_N);

 private:
  double step_s_;
  double lag_s_;  // of the reading behind a ramp, 2ζ/ω
  // The free motion over one step.
  double value_by_value_;
  double value_by_rate_s_;
  double rate_by_value_per_s_;
  double rate_by_rate_;
  bool started_ = false;
  double force_N_ = 0.0;
  double reading_N_ = 0.0;
  double rate_N_per_s_ = 0.0;
};

}  // namespace slipstack::sim
