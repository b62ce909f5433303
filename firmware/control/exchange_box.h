// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace slipstack {

/// Passes a value to the tick, which interrupts the main loop wherever it is: it is written into the place
/// that the tick does not read, and the places are exchanged by one store.
template <class T>
class ExchangeBox {
 public:
  /// Outside the tick.
  void write(const T& value) {
    const std::uint32_t spare = newest_.load(std::memory_order_relaxed) ^ 1U;
    values_[spare] = value;
    newest_.store(spare, std::memory_order_release);
  }
  /// The newest value; in the tick and outside it.
  const T& read() const { return values_[newest_.load(std::memory_order_acquire)]; }

 private:
  std::array<T, 2> values_{};
  std::atomic<std::uint32_t> newest_{0};
};

}  // namespace slipstack
