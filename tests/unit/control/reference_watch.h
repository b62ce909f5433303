// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "firmware/control/reference/reference.h"

namespace slipstack {

/// How a reference moves, by differences of its positions, apart from what the generator says. Counts and
/// ticks.
class ReferenceWatch {
 public:
  std::int64_t ticks = 0;
  double way = 0.0, velocity = 0.0, acceleration = 0.0;
  double fastest = 0.0, hardest = 0.0, sharpest = 0.0;  ///< largest velocity, acceleration, jerk

 protected:
  void see(const ReferencePoint& point) {
    const double step = static_cast<double>(difference(point.counts, last_)) +
                        static_cast<double>(point.fraction) - fraction_;
    if (ticks > 2) {
      fastest = std::max(fastest, std::abs(step));
      hardest = std::max(hardest, std::abs(step - velocity));
      sharpest = std::max(sharpest, std::abs(step - velocity - acceleration));
    }
    way += step;
    acceleration = step - velocity;
    velocity = step;
    last_ = point.counts;
    fraction_ = static_cast<double>(point.fraction);
    ++ticks;
  }
  /// It stands here.
  void stands(std::int32_t counts) {
    last_ = counts;
    fraction_ = velocity = acceleration = 0.0;
  }

 private:
  std::int32_t last_ = 0;
  double fraction_ = 0.0;
};

}  // namespace slipstack
