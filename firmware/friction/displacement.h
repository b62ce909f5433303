// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <type_traits>

namespace slipstack {

/// What a displacement may be: absolute encoder counts on the controller, metres in the workbench.
template <class T>
concept DisplacementType = std::same_as<T, std::int32_t> || std::floating_point<T>;

/// a - b, in the unit of both. Counts are subtracted modulo 2^32, so that a counter that wraps around
/// does no harm as long as the true difference stays below 2^31 counts. One instruction.
template <DisplacementType T>
constexpr T difference(T a, T b) {
  if constexpr (std::integral<T>) {
    return static_cast<T>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
  } else {
    return a - b;
  }
}

/// a + b, in the unit of both, modulo 2^32 for counts.
template <DisplacementType T>
constexpr T sum(T a, T b) {
  if constexpr (std::integral<T>) {
    return static_cast<T>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
  } else {
    return a + b;
  }
}

/// Why a model refuses its parameters. Nothing is changed when a setter returns anything but kOk.
enum class SetupStatus : std::uint8_t {
  kOk,
  kTooMany,       ///< more elements or knots than the capacity
  kSizeMismatch,  ///< arrays that belong together differ in length
  kOutOfRange,    ///< negative, not finite, or beyond what the representation holds
  kNotAscending,  ///< knots out of order
};

}  // namespace slipstack
