// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "firmware/effects/approx.h"

namespace slipstack {

/// Slow adaptation of the hysteresis level: friction = level x dry friction of the model + other forces. The
/// level differs from its nominal 1 because the preload does, along the rail and with temperature ([1], [2]).
///
/// Recursive least squares for one unknown, with forgetting; residual r = (true level - level) x dry:
///
///   k = P dry / (forgetting + P dry^2),  level <- clamp(level + k r),  P <- min(P (1 - k dry) / forgetting,
///   Pmax).
///
/// In the main loop, from what the ticks leave for it; level() is read in the tick.
///
/// Bounded whatever the input: level stays within its limits, 0 < P <= Pmax, |k dry| < 1. The compensator is
/// evaluated on the reference, so that a wrong level is a bounded force and not a feedback: docs/control.md.
class LevelAdaptation {
 public:
  /// Constants of the tick; made outside it.
  struct Bounds {
    float lowest = 1.0F;
    float highest = 1.0F;
    float forgetting = 1.0F;
    float smallest_variance_per_N2 = 0.0F;  ///< above zero, so that it never stops to learn
    float largest_variance_per_N2 = 0.0F;
  };
  static Bounds bounds(float lowest, float highest, float memory_s, float tick_s) {
    const float forgotten = tick_s / memory_s;
    // Below 1 also where the memory is longer than what a float resolves.
    const float forgetting = approx::clamp(1.0F - forgotten, 0.0F, 0x1.fffffep-1F);
    return {lowest, highest, forgetting, 1.0e-6F * forgotten, forgotten};
  }

  /// One step with the dry friction of the model at level 1, and the force that the model at the present
  /// level misses, both in N. Takes part only when both are finite.
  void step(const Bounds& bound, float dry_N, float residual_N) {
    const float weighted = variance_ * dry_N;
    const float share = 1.0F / (bound.forgetting + weighted * dry_N);
    const float next = level() + weighted * share * residual_N;
    if (!approx::is_finite(next)) return;
    level_.store(approx::clamp(next, bound.lowest, bound.highest), std::memory_order_relaxed);
    // (1 - k dry) / forgetting is the same as this share.
    variance_ =
        approx::clamp(variance_ * share, bound.smallest_variance_per_N2, bound.largest_variance_per_N2);
  }

  /// Brings the level within other bounds.
  void limit(const Bounds& bound) {
    level_.store(approx::clamp(level(), bound.lowest, bound.highest), std::memory_order_relaxed);
  }

  float level() const { return level_.load(std::memory_order_relaxed); }
  float variance_per_N2() const { return variance_; }

 private:
  std::atomic<float> level_{1.0F};
  float variance_ = 1.0e-7F;  // small: the level starts as trusted
};

}  // namespace slipstack
