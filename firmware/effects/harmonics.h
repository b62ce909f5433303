// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "firmware/effects/approx.h"

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

/// The sum of gains times harmonics, as the real part of w (c1 + w (c2 + ...)) with w = cos + i sin and
/// c = A - i B: the same as the products with harmonics(), to rounding.
template <class Real>
constexpr Real harmonic_sum(approx::SinCos<Real> w,
                            const std::array<Real, std::size_t{2} * kRippleHarmonics>& gains) {
  constexpr std::size_t kLast = std::size_t{2} * (kRippleHarmonics - 1);
  Real real = gains[kLast];
  Real imaginary = -gains[kLast + 1];
  for (std::size_t h = kLast; h > 0; h -= 2) {
    const Real turned = gains[h - 2] + w.cos * real - w.sin * imaginary;
    imaginary = w.cos * imaginary + w.sin * real - gains[h - 1];
    real = turned;
  }
  return w.cos * real - w.sin * imaginary;
}

}  // namespace slipstack
