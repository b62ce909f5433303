// SPDX-License-Identifier: Apache-2.0
// The test programme that a user runs to record a log.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "sim_host/motion/segment.h"
#include "sim_host/plant/axis.h"
#include "sim_host/rng.h"

namespace slipstack::sim {

/// Segments one after another; before the first and after the last the axis is at standstill.
class MotionProgramme {
 public:
  void append(std::unique_ptr<Segment> segment);
  double duration_s() const { return starts_s_.empty() ? 0.0 : end_s_; }
  /// Position, velocity and acceleration at a time. Cost: O(log segments).
  MotionPoint at(double t_s) const;
  std::size_t segments() const { return segments_.size(); }

 private:
  std::vector<std::unique_ptr<Segment>> segments_;
  std::vector<double> starts_s_;
  double end_s_ = 0.0;
};

/// Requirements on a programme.
struct ProgrammeOptions {
  double seconds = 60.0;         // at least 8
  double smallest_loop_m = 0.0;  // 0: 0.35 × the pre-sliding travel
  double largest_loop_m = 0.0;   // 0: 2 to 4 × the pre-sliding travel
};

/// Pre-sliding loops of stepped amplitude at several places, slow traverses at several speeds with smooth
/// reversals, pick-and-place moves with dwells; about a quarter, a half and a quarter of the time. The whole
/// takes `seconds`, from 20 s on up to 3 % more; at the least some 9 to 15 s. Throws std::invalid_argument
/// when `seconds` is below 8.
MotionProgramme make_test_programme(const Axis& axis, const ProgrammeOptions& options, Rng& rng);

}  // namespace slipstack::sim
