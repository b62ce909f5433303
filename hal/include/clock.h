// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>

namespace slipstack {

/// A free-running counter, modulo 2^32, for time stamps, jitter and the duration of the tick. Differences are
/// taken modulo 2^32. Its rate is at least 1 MHz (on the emulated board it counts instructions).
template <class C>
concept Clock = requires(const C clock) {
  { clock.now() } -> std::same_as<std::uint32_t>;
  { clock.ticks_per_second() } -> std::same_as<std::uint32_t>;
};

}  // namespace slipstack
