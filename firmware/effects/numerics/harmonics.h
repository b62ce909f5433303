// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// Harmonics of the pitch that a ripple effect carries.
inline constexpr int kRippleHarmonics = 4;

/// cos and sin of the first harmonics from those of the fundamental, by rotation: four products a harmonic.
template <class Real>
constexpr void harmonics(approx::SinCos<Real> fundamental,
                         std::span<Real, std::size_t{2} * kRippleHarmonics> out) {
  Real cosine = fundamental.cos;
  Real sine = fundamental.sin;
  for (std::size_t h = 0; h < kRippleHarmonics; ++h) {
    out[2 * h] = cosine;
    out[2 * h + 1] = sine;
    const Real next = cosine * fundamental.cos - sine * fundamental.sin;
    sine = sine * fundamental.cos + cosine * fundamental.sin;
    cosine = next;
  }
}

}  // namespace slipstack
