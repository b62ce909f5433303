// SPDX-License-Identifier: Apache-2.0
// The reference marks of an incremental scale with distance-coded marks.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim_host/sensors/encoder.h"

namespace slipstack::sim {

/// As the makers of such scales draw them: marks at equal distances, and between each two of them one more,
/// which is one step farther from the middle than the one between the two before.
struct CodedScale {
  /// Places on the rail of `pairs` pairs of marks. `zero_m`: of the scale, which is read in the direction
  /// `direction`, 1 or -1; the first mark is one `distance_m` from there.
  static CodedScale drawn(double zero_m, int direction, double distance_m, double step_m, int pairs) {
    CodedScale scale;
    for (int k = 1; k <= pairs; ++k) {
      const double even_m = k * distance_m;
      const double between_m = even_m + 0.5 * distance_m + k * step_m;
      scale.marks_m.push_back(zero_m + direction * even_m);
      scale.marks_m.push_back(zero_m + direction * between_m);
    }
    std::sort(scale.marks_m.begin(), scale.marks_m.end());
    return scale;
  }

  /// The counts at which a mark was passed on the way between two ticks, the last one if several.
  std::optional<std::int32_t> passed(const Encoder& encoder, double from_m, double to_m) const {
    std::optional<std::int32_t> last;
    const bool up = to_m >= from_m;
    for (std::size_t i = 0; i < marks_m.size(); ++i) {
      const double mark_m = marks_m[up ? i : marks_m.size() - 1 - i];
      const bool between = up ? mark_m > from_m && mark_m <= to_m : mark_m >= to_m && mark_m < from_m;
      if (between) last = static_cast<std::int32_t>(encoder.counts(mark_m));
    }
    return last;
  }

  std::vector<double> marks_m;  ///< in ascending order
};

}  // namespace slipstack::sim
