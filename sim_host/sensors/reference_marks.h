// SPDX-License-Identifier: Apache-2.0
// Reference marks of an incremental encoder: the counts at which one was passed.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "sim_host/sensors/encoder.h"

namespace slipstack::sim {

struct ReferenceMarks {
  double first_m = 0.0;
  double distance_m = 0.0;  ///< from one mark to the next; 0: there is one only

  /// The counts at which a mark was passed on the way between two ticks, the last one if several.
  std::optional<std::int32_t> passed(const Encoder& encoder, double from_m, double to_m) const {
    const double low = std::min(from_m, to_m);
    const double high = std::max(from_m, to_m);
    const bool up = to_m >= from_m;
    double mark_m = first_m;
    if (distance_m > 0.0) {
      const double steps =
          up ? std::floor((high - first_m) / distance_m) : std::ceil((low - first_m) / distance_m);
      mark_m += steps * distance_m;
    }
    // A mark that lies where a tick ends belongs to that tick alone.
    const bool between = up ? mark_m > low && mark_m <= high : mark_m >= low && mark_m < high;
    if (!between) return std::nullopt;
    return static_cast<std::int32_t>(encoder.counts(mark_m));
  }
};

/// Of the simulated drives.
inline constexpr ReferenceMarks kMarks{.first_m = 0.004, .distance_m = 0.02};

}  // namespace slipstack::sim
