// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// A notch (s^2 + 2 depth zeta w s + w^2) / (s^2 + 2 zeta w s + w^2), bilinear with the centre frequency
/// kept. Unity far from the centre, `depth` (0 to 1) at it. Transposed direct form II.
class Notch {
 public:
  /// Constants of the tick; made outside it.
  struct Gains {
    float b0 = 1.0F, b1 = 0.0F, b2 = 0.0F, a1 = 0.0F, a2 = 0.0F;
  };
  /// Frequency 0 switches it off. Otherwise 0 < frequency < 0.45 / tick, damping > 0.
  static Gains gains(float frequency_Hz, float damping, float depth, float tick_s) {
    if (!(frequency_Hz > 0.0F)) return {};
    const auto half = approx::sin_cos_of_cycles(0.5F * frequency_Hz * tick_s);
    const float w = half.sin / half.cos;  // tan(pi f T)
    const float w2 = w * w;
    const float wide = 2.0F * damping * w;
    const float scale = 1.0F / (1.0F + wide + w2);
    const float middle = 2.0F * (w2 - 1.0F) * scale;
    return {(1.0F + depth * wide + w2) * scale, middle, (1.0F - depth * wide + w2) * scale, middle,
            (1.0F - wide + w2) * scale};
  }

  void reset() { first_ = second_ = 0.0F; }

  float step(const Gains& gain, float in) {
    const float out = first_ + gain.b0 * in;
    first_ = gain.b1 * in - gain.a1 * out + second_;
    second_ = gain.b2 * in - gain.a2 * out;
    return out;
  }

 private:
  float first_ = 0.0F, second_ = 0.0F;
};

}  // namespace slipstack
