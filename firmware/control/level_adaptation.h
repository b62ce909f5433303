// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace slipstack {

/// Slow adaptation of the hysteresis level: friction = level x dry friction of the model + the rest. The
/// level differs from its nominal 1 because the preload does, along the rail and with temperature ([1], [2]).
///
/// Recursive least squares for one unknown, with forgetting; residual r = (true level - level) x dry:
///
///   k = P dry / (forgetting + P dry^2),  level <- clamp(level + k r),  P <- min(P (1 - k dry) / forgetting,
///   Pmax).
///
/// Bounded whatever the input: level stays within its limits, 0 < P <= Pmax, |k dry| < 1. The compensator is
/// evaluated on the reference, so that a wrong level is a bounded force and not a feedback: docs/control.md.
/// 18 instructions.
class LevelAdaptation {
 public:
  /// Constants of the tick; made outside it.
  struct Bounds {
    float lowest = 1.0F;
    float highest = 1.0F;
    float forgetting = 1.0F;
    float per_forgetting = 1.0F;
    float largest_variance_per_N2 = 0.0F;
  };
  static Bounds bounds(float lowest, float highest, float memory_s, float tick_s) {
    const float forgetting = 1.0F - tick_s / memory_s;
    return {lowest, highest, forgetting, 1.0F / forgetting, tick_s / memory_s};
  }

  /// One tick with the dry friction of the model at level 1, and the force that the model at the present
  /// level misses, both in N. Takes part only when both are finite.
  void step(const Bounds& bound, float dry_N, float residual_N) {
    const float weighted = variance_ * dry_N;
    const float gain = weighted / (bound.forgetting + weighted * dry_N);
    const float next = level_ + gain * residual_N;
    if (!(next > -1.0e6F && next < 1.0e6F)) return;
    level_ = limited(bound, next);
    const float variance = variance_ * (1.0F - gain * dry_N) * bound.per_forgetting;
    variance_ = variance < bound.largest_variance_per_N2 ? variance : bound.largest_variance_per_N2;
  }

  /// Brings the level within other bounds.
  void limit(const Bounds& bound) { level_ = limited(bound, level_); }

  float level() const { return level_; }
  float variance_per_N2() const { return variance_; }

 private:
  static float limited(const Bounds& bound, float level) {
    const float above = level > bound.lowest ? level : bound.lowest;
    return above < bound.highest ? above : bound.highest;
  }

  float level_ = 1.0F;
  float variance_ = 1.0e-7F;  // small: the level starts as trusted
};

}  // namespace slipstack
