// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>

#include "firmware/control/parameters/parameters.h"
#include "firmware/control/reference/reference.h"

namespace slipstack {

/// The last ticks: what each read, where the reference was, and what it says about the level of the friction.
/// The tick looks back by the lead of its feed-forward; the main loop follows behind.
class TickHistory {
 public:
  static constexpr std::uint32_t kTicks = 64;
  /// How many ticks the main loop may be late without missing one.
  static constexpr std::uint32_t kLatest = kTicks - 8;

  /// What a tick says about the level.
  struct Residual {
    float dry_N = 0.0F;
    float residual_N = std::numeric_limits<float>::quiet_NaN();  ///< none: it says nothing
    std::int32_t place = 0;                                      ///< where the hysteresis was, in its steps
  };

  /// What a tick read, and the current that had been commanded until then.
  struct Reading {
    std::int32_t counts = 0;
    std::uint32_t levels = 0;  ///< of the input terminals
    float current_A = 0.0F;
  };

  /// Together, so that the tick finds its place once.
  struct Entry {
    ReferencePoint point;
    Residual residual;
    Reading reading;
  };

  // ---- in the tick ----

  /// An index mark passed at these counts.
  void index_passed(std::int32_t counts) {
    index_counts_ = counts;
    index_number_.store(index_number_.load(std::memory_order_relaxed) + 1U, std::memory_order_release);
  }

  /// Where to write what this tick leaves.
  Entry& entry(std::uint32_t tick) { return entries_[tick % kTicks]; }
  const ReferencePoint& point(std::uint32_t tick) const { return entries_[tick % kTicks].point; }
  /// The point that the model saw `lead` ticks ago.
  const ReferencePoint& behind(std::uint32_t tick, std::int32_t lead) const {
    return point(tick - static_cast<std::uint32_t>(lead));
  }
  /// The reference began anew in this tick: no point from before is waited for.
  void begin_anew(std::uint32_t tick) { begin_ = tick; }
  /// Of this lead, what has a history.
  std::int32_t lead_within(std::uint32_t tick, std::int32_t lead) const {
    const std::uint32_t history = tick - begin_;
    return history < static_cast<std::uint32_t>(lead) ? static_cast<std::int32_t>(history) : lead;
  }
  const Reading& reading(std::uint32_t tick) const { return entries_[tick % kTicks].reading; }

  // ---- outside the tick ----

  /// The ticks behind `seen` up to `last`, which is moved there: visit(Entry, missed) for each that is still
  /// there when it has been copied; `missed`: how many before it were not. `now()`: the tick now. At most
  /// kLatest visits.
  template <class Now, class Visit>
  void follow(std::uint32_t& seen, std::uint32_t last, Now&& now, Visit&& visit) const {
    std::uint32_t missed = 0;
    if (last - seen > kLatest) {
      missed = last - seen - kLatest;
      seen = last - kLatest;
    }
    while (seen != last) {
      const Entry entry = entries_[++seen % kTicks];
      std::atomic_signal_fence(std::memory_order_acquire);
      if (now() - seen >= kTicks) {
        ++missed;
        continue;
      }
      visit(entry, missed);
      missed = 0;
    }
  }
  /// Index marks that passed since the start, and where the last one was.
  std::uint32_t index_number() const { return index_number_.load(std::memory_order_acquire); }
  std::int32_t index_counts() const { return index_counts_; }

 private:
  static_assert(kLargestLeadTicks < static_cast<std::int32_t>(kTicks));

  std::uint32_t begin_ = 0;
  std::array<Entry, kTicks> entries_{};
  std::int32_t index_counts_ = 0;
  std::atomic<std::uint32_t> index_number_{0};
};

}  // namespace slipstack
