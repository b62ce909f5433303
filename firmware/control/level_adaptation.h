// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "firmware/effects/approx.h"

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
    float smallest_variance_per_N2 = 0.0F;  ///< above zero, so that it never stops to learn
    float largest_variance_per_N2 = 0.0F;
  };
  static Bounds bounds(float lowest, float highest, float memory_s, float tick_s) {
    const float forgotten = static_cast<float>(kEvery) * tick_s / memory_s;
    const float forgetting = 1.0F - forgotten;
    return {lowest, highest, forgetting, 1.0e-6F * forgotten, forgotten};
  }

  /// It is slow by intent: one step in kEvery ticks is enough.
  static constexpr std::int8_t kEvery = 2;

  /// One step with the dry friction of the model at level 1, and the force that the model at the present
  /// level misses, both in N. Takes part only when both are finite.
  [[gnu::always_inline]] void step(const Bounds& bound, float dry_N, float residual_N) {
    const float weighted = variance_ * dry_N;
    const float share = 1.0F / approx::multiply_add(weighted, dry_N, bound.forgetting);
    const float next = approx::multiply_add(weighted * share, residual_N, level_);
    // All bits of the exponent set: infinite, or not a number.
    if ((std::bit_cast<std::uint32_t>(next) & 0x7F800000U) == 0x7F800000U) return;
    level_ = limited(bound.lowest, bound.highest, next);
    // (1 - k dry) / forgetting is the same as this share.
    variance_ = limited(bound.smallest_variance_per_N2, bound.largest_variance_per_N2, variance_ * share);
  }

  /// Brings the level within other bounds.
  void limit(const Bounds& bound) { level_ = limited(bound.lowest, bound.highest, level_); }

  float level() const { return level_; }
  float variance_per_N2() const { return variance_; }

 private:
  // For positive bounds: then the bits compare as the numbers do.
  static float limited(float smallest, float largest, float value) {
    const auto low = std::bit_cast<std::int32_t>(smallest);
    const auto high = std::bit_cast<std::int32_t>(largest);
    const auto wanted = std::bit_cast<std::int32_t>(value);
    const std::int32_t above = wanted > low ? wanted : low;
    return std::bit_cast<float>(above < high ? above : high);
  }

  float level_ = 1.0F;
  float variance_ = 1.0e-7F;  // small: the level starts as trusted
};

}  // namespace slipstack
