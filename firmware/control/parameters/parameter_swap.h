// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace slipstack {

/// Two sets of prepared parameters: the tick uses one while the other is filled outside it. The change takes
/// place at the begin of a tick and costs it nothing: what the new set continues from the old one (the state
/// of the hysteresis) is copied outside the tick too, for the one tick that follows. If a tick came in
/// between, that copy is out of date, the change does not take place, and arm() is called again.
template <class Set>
class ParameterSwap {
 public:
  /// In the tick: begins it; true when a new set came into force.
  bool begin_tick() {
    const std::uint32_t tick = tick_.load(std::memory_order_relaxed);
    const bool take =
        armed_.load(std::memory_order_relaxed) && armed_for_.load(std::memory_order_relaxed) == tick;
    // Who arms shares the core with the tick: only the compiler must keep the order.
    if (take) {
      std::atomic_signal_fence(std::memory_order_acquire);
      active_.store(active_.load(std::memory_order_relaxed) ^ 1U, std::memory_order_relaxed);
      armed_.store(false, std::memory_order_relaxed);
      std::atomic_signal_fence(std::memory_order_release);
      pending_.store(false, std::memory_order_relaxed);
    }
    std::atomic_signal_fence(std::memory_order_release);
    tick_.store(tick + 1, std::memory_order_relaxed);
    return take;
  }

  Set& active() { return sets_[active_.load(std::memory_order_relaxed)]; }
  const Set& active() const { return sets_[active_.load(std::memory_order_relaxed)]; }
  std::uint32_t tick() const { return tick_.load(std::memory_order_relaxed); }

  /// Outside the tick: the set to fill, or nullptr while a change is under way.
  Set* spare() {
    if (pending_.load(std::memory_order_acquire)) return nullptr;
    return &sets_[active_.load(std::memory_order_relaxed) ^ 1U];
  }

  /// Outside the tick, after filling the spare set, and again from the main loop while pending(): continues
  /// the motion of the active set, and has the next tick take the new one.
  void arm() {
    pending_.store(true, std::memory_order_relaxed);
    armed_.store(false, std::memory_order_release);
    const std::uint32_t tick = tick_.load(std::memory_order_acquire);
    const std::uint32_t active = active_.load(std::memory_order_relaxed);
    sets_[active ^ 1U].continue_from(sets_[active]);
    armed_for_.store(tick, std::memory_order_relaxed);
    armed_.store(true, std::memory_order_release);
  }

  /// Outside the tick: calls `visit` with both sets, for what the tick reads through a box of its own.
  template <class Visit>
  void each(Visit&& visit) {
    for (Set& set : sets_) visit(set);
  }

  bool pending() const { return pending_.load(std::memory_order_acquire); }

 private:
  std::atomic<std::uint32_t> active_{0};
  std::atomic<std::uint32_t> tick_{0};
  std::atomic<bool> armed_{false};
  std::atomic<bool> pending_{false};
  std::atomic<std::uint32_t> armed_for_{0};
  std::array<Set, 2> sets_{};
};

}  // namespace slipstack
