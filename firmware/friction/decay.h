// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>

namespace slipstack {

namespace detail {

// e^-r - 1 for abs(r) <= ln(2)/2: the Taylor series in Horner form, cut where its next term falls below half
// a unit in the last place of Real (r^9/9! = 2e-10 relative for float, r^15/15! = 1e-19 for double).
template <std::floating_point Real>
constexpr Real decay_minus_one(Real r) {
  constexpr int kTerms = sizeof(Real) == sizeof(float) ? 8 : 14;
  // 1/2 ... 1/14; a division by a constant integer would round differently from a multiplication, so the
  // reciprocals are written once and used on every platform.
  constexpr Real kReciprocal[] = {Real(1) / 2,  Real(1) / 3,  Real(1) / 4, Real(1) / 5,  Real(1) / 6,
                                  Real(1) / 7,  Real(1) / 8,  Real(1) / 9, Real(1) / 10, Real(1) / 11,
                                  Real(1) / 12, Real(1) / 13, Real(1) / 14};
  const Real v = -r;
  Real p = Real(1);
  for (int n = kTerms; n >= 2; --n) p = Real(1) + v * kReciprocal[n - 2] * p;
  return v * p;
}

// 2^-n for 0 <= n <= 126 (float) or 1022 (double), by writing the exponent.
template <std::floating_point Real>
constexpr Real power_of_half(int n) {
  if constexpr (sizeof(Real) == sizeof(float)) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(127 - n) << 23);
  } else {
    return std::bit_cast<double>(static_cast<std::uint64_t>(1023 - n) << 52);
  }
}

}  // namespace detail

// e^-u and 1 - e^-u together, both to within 1.5 epsilon for double, 0.9 for float.
template <std::floating_point Real>
struct Decay {
  Real remaining;  // e^-u
  Real gone;       // 1 - e^-u, without the cancellation that 1 - e^-u has for small u
};

// Decay of u >= 0, dimensionless. The same bits on host and target: additions and multiplications only, no C
// library. Above u = 87 (float) or 700 (double) `remaining` keeps its value there. Constant work: about 40
// instructions on a Cortex-M4F.
template <std::floating_point Real>
constexpr Decay<Real> decay(Real u) {
  constexpr Real kLargest = sizeof(Real) == sizeof(float) ? Real(87) : Real(700);
  constexpr Real kLog2E = Real(1.44269504088896340736L);
  // ln 2 in two parts (after Cody and Waite); the first has its low bits zero so that n * kLn2High is exact.
  constexpr Real kLn2High = sizeof(Real) == sizeof(float) ? Real(0x1.62ep-1) : Real(0x1.62e42fefa0000p-1);
  constexpr Real kLn2Low =
      sizeof(Real) == sizeof(float) ? Real(0x1.0bfbe8e7bcd5ep-15) : Real(0x1.cf79abc9e3b3ap-40);
  if (!(u < kLargest)) u = kLargest;
  const int n = static_cast<int>(u * kLog2E + Real(0.5));
  const Real whole = static_cast<Real>(n);
  const Real r = (u - whole * kLn2High) - whole * kLn2Low;
  const Real m = detail::decay_minus_one(r);
  const Real scale = detail::power_of_half<Real>(n);
  return {scale + scale * m, (Real(1) - scale) - scale * m};
}

}  // namespace slipstack
