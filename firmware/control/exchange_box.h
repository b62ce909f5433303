// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>

namespace slipstack {

/// Passes a value to the tick, which interrupts the main loop wherever it is: it is written into the place
/// that the tick does not read, and the places are exchanged by one store.
template <class T>
class ExchangeBox {
 public:
  /// Outside the tick.
  void write(const T& value) {
    T* const spare = newest_.load(std::memory_order_relaxed) == &values_[0] ? &values_[1] : &values_[0];
    *spare = value;
    newest_.store(spare, std::memory_order_release);
  }
  /// The newest value; in the tick and outside it.
  const T& read() const {
    const T& newest = *newest_.load(std::memory_order_relaxed);
    // Both run on one core: only the compiler must keep the order.
    std::atomic_signal_fence(std::memory_order_acquire);
    return newest;
  }

  ExchangeBox() = default;
  // Points into itself.
  ExchangeBox(const ExchangeBox&) = delete;
  ExchangeBox& operator=(const ExchangeBox&) = delete;
  ExchangeBox(ExchangeBox&&) = delete;
  ExchangeBox& operator=(ExchangeBox&&) = delete;
  ~ExchangeBox() = default;

 private:
  std::array<T, 2> values_{};
  std::atomic<const T*> newest_{&values_[0]};
};

}  // namespace slipstack
