// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace slipstack {

/// What counts the intervals of a table: a whole number, or what a scalar that records has in its place.
template <class Real>
struct IndexOf {
  using type = std::size_t;
};

/// A place in a row of intervals of length 1: the interval, and how far into it.
template <class Real>
struct IntervalPlace {
  typename IndexOf<Real>::type interval;
  Real t;
};

/// The interval of 0 <= place <= count; the end of the row belongs to the last one.
template <class Real>
constexpr IntervalPlace<Real> interval_at(Real place, std::size_t count) {
  const auto whole = static_cast<std::size_t>(static_cast<std::int32_t>(place));
  const std::size_t interval = whole < count ? whole : count - 1;
  return {interval, place - static_cast<Real>(static_cast<std::int32_t>(interval))};
}

/// The values from that of this interval on: [0], [1] ...
template <std::size_t N, class Real>
constexpr const Real* values_from(const std::array<Real, N>& values, std::size_t interval) {
  return values.data() + interval;
}

}  // namespace slipstack
