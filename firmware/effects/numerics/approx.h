// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

// Elementary functions for the tick. A C library's exp, sin and pow differ from one platform to the next in
// the last bit; these are a fixed sequence of multiplications and additions, so host and target agree bit
// for bit. One definition, one shape: the series end where float does, so double is no better than they are.
// The errors below are the largest found on dense grids and random input
// (tests/unit/effects/approx_test.cpp); "u" is the distance from 1 to the next float, 1.2e-7.
namespace slipstack::approx {

/// |x|, without a call of a library.
template <class Real>
constexpr Real absolute(Real x) {
  if constexpr (std::is_same_v<Real, float>) {
    return __builtin_fabsf(x);
  } else {
    return __builtin_fabs(x);
  }
}

/// Whether x is neither infinite nor NaN.
constexpr bool is_finite(float x) {
  // Of those, all bits of the exponent are set.
  return (std::bit_cast<std::uint32_t>(x) & 0x7F800000U) != 0x7F800000U;
}

/// x within [low, high]; NaN becomes low, so that what is clamped is always fit for an index.
template <class Real>
constexpr Real clamp(Real x, Real low, Real high) {
  const Real above = x > low ? x : low;
  return above > high ? high : above;
}

/// `yes` where the condition holds, else `no`; both are computed. An effect that chooses between values by
/// `?:` computes the same, but cannot be exported: only this tells a scalar that records of the choice.
template <class Condition, class Real>
constexpr Real select(Condition condition, Real yes, Real no) {
  return condition ? yes : no;
}

/// Largest integer not above x, for |x| < 2^31.
template <class Real>
constexpr std::int32_t floor_to_int(Real x) {
  const auto truncated = static_cast<std::int32_t>(x);
  return truncated - (static_cast<Real>(truncated) > x ? 1 : 0);
}

/// 2^n for an integer -120 <= n <= 120, from the exponent field.
template <class Real>
constexpr Real power_of_two(std::int32_t n) {
  if constexpr (std::is_same_v<Real, float>) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(n + 127) << 23);
  } else {
    return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52);
  }
}

/// 2^x as 2^whole (1 + fraction): whole is the integer nearest to x.
template <class Real>
struct SplitExp2 {
  Real power;
  Real fraction;
};

/// x is clamped to [-100, 100]. Taylor series of degree 7 on half an octave, exact at x = 0.
template <class Real>
constexpr SplitExp2<Real> split_exp2(Real x) {
  const Real bounded = clamp(x, Real(-100), Real(100));
  const std::int32_t whole = floor_to_int(bounded + Real(0.5));
  const Real y = (bounded - static_cast<Real>(whole)) * Real(0.69314718055994531);
  Real sum = Real(1.0 / 5040);
  sum = sum * y + Real(1.0 / 720);
  sum = sum * y + Real(1.0 / 120);
  sum = sum * y + Real(1.0 / 24);
  sum = sum * y + Real(1.0 / 6);
  sum = sum * y + Real(0.5);
  sum = sum * y + Real(1);
  return {power_of_two<Real>(whole), sum * y};
}

/// 2^x; x is clamped to [-100, 100]. Relative error 8e-9 in double, u in float.
template <class Real>
constexpr Real exp2(Real x) {
  const auto [power, fraction] = split_exp2(x);
  return power * fraction + power;
}

/// exp(x), by exp2; x is clamped to [-69, 69]. Relative error 8e-9 in double, u (1.2 + 0.65 |x|) in float.
template <class Real>
constexpr Real exp(Real x) {
  return exp2(x * Real(1.4426950408889634));
}

/// exp(x) - 1 without cancellation near zero: relative error 2.5e-8 in double,
/// u (2.5 + 0.65 |x|) in float.
template <class Real>
constexpr Real exp_minus_one(Real x) {
  const auto [power, fraction] = split_exp2(x * Real(1.4426950408889634));
  return power * fraction + (power - Real(1));
}

/// log2(x) for a normal x > 0. Odd series in (m-1)/(m+1) with the mantissa m in [1/sqrt 2, sqrt 2). Relative
/// error 2.5e-9 in double, 2.5 u in float; exact at powers of two.
template <class Real>
constexpr Real log2(Real x) {
  std::int32_t exponent = 0;
  Real mantissa = Real(1);
  if constexpr (std::is_same_v<Real, float>) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    exponent = static_cast<std::int32_t>(bits >> 23) - 127;
    mantissa = std::bit_cast<float>((bits & 0x007FFFFFu) | 0x3F800000u);
  } else {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    exponent = static_cast<std::int32_t>(bits >> 52) - 1023;
    mantissa = std::bit_cast<double>((bits & 0x000FFFFFFFFFFFFFull) | 0x3FF0000000000000ull);
  }
  const bool upper = mantissa > Real(1.4142135623730951);
  mantissa = upper ? mantissa * Real(0.5) : mantissa;
  exponent += upper ? 1 : 0;
  const Real s = (mantissa - Real(1)) / (mantissa + Real(1));
  const Real s2 = s * s;
  Real sum = Real(1.0 / 9);
  sum = sum * s2 + Real(1.0 / 7);
  sum = sum * s2 + Real(1.0 / 5);
  sum = sum * s2 + Real(1.0 / 3);
  sum = sum * s2 + Real(1);
  return static_cast<Real>(exponent) + sum * s * Real(2.8853900817779268);
}

/// base^exponent for base >= 0; base below 1e-30 counts as 1e-30, and the result stays within 2^-100 ..
/// 2^100. Relative error 1e-8 in double, u (2 + 0.6 |log2 of the result|) in float.
template <class Real>
constexpr Real power(Real base, Real exponent) {
  const Real positive = base < Real(1e-30) ? Real(1e-30) : base;
  return exp2(exponent * log2(positive));
}

template <class Real>
struct SinCos {
  Real sin;
  Real cos;
};

/// Sine and cosine of 2*pi*cycles. Series of degree 9 and 8 on an eighth of a cycle. Absolute error 2.5e-8 in
/// double for |cycles| < 2^29; 0.8 u in float for |cycles| < 2^21 (where a float still holds quarter cycles),
/// the error of `cycles` itself aside.
template <class Real>
constexpr SinCos<Real> sin_cos_of_cycles(Real cycles) {
  const Real quarters = cycles * Real(4);
  const std::int32_t quadrant = floor_to_int(quarters + Real(0.5));
  const Real angle = (quarters - static_cast<Real>(quadrant)) * Real(1.5707963267948966);
  const Real a2 = angle * angle;
  Real sine = Real(1.0 / 362880);
  sine = sine * a2 - Real(1.0 / 5040);
  sine = sine * a2 + Real(1.0 / 120);
  sine = sine * a2 - Real(1.0 / 6);
  sine = sine * a2 * angle + angle;
  Real cosine = Real(1.0 / 40320);
  cosine = cosine * a2 - Real(1.0 / 720);
  cosine = cosine * a2 + Real(1.0 / 24);
  cosine = cosine * a2 - Real(0.5);
  cosine = cosine * a2 + Real(1);
  const bool swap = (quadrant & 1) != 0;
  const Real s = swap ? cosine : sine;
  const Real c = swap ? sine : cosine;
  return {(quadrant & 2) != 0 ? -s : s, ((quadrant + 1) & 2) != 0 ? -c : c};
}

/// Square root of a normal a, 0 for a <= 0, for set-up code: two steps of Newton's iteration from
/// exp2(log2(a) / 2). Correct to the last bit or its neighbour; in double for 2^-200 < a < 2^200.
template <class Real>
constexpr Real square_root(Real a) {
  if (!(a > Real(0))) return Real(0);
  Real root = exp2(Real(0.5) * log2(a));
  for (int step = 0; step < 2; ++step) root = Real(0.5) * (root + a / root);
  return root;
}

/// Square root of a >= 0, correctly rounded: one instruction where the processor has it. For the tick.
inline float fast_square_root(float a) {
  return __builtin_sqrtf(a);
}

}  // namespace slipstack::approx
