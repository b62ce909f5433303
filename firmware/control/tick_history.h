// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>

#include "firmware/control/parameters.h"
#include "firmware/control/reference.h"

namespace slipstack {

/// The last ticks: where the reference was, and what each says about the level of the friction. The tick
/// looks back by the lead of its feed-forward; the main loop follows behind.
class TickHistory {
 public:
  static constexpr std::uint32_t kTicks = 64;
  /// How many ticks the main loop may be late without missing one.
  static constexpr std::uint32_t kLatest = kTicks - 8;

  /// What a tick says about the level.
  struct Residual {
    float dry_N = 0.0F;
    float residual_N = std::numeric_limits<float>::quiet_NaN();  ///< none: it says nothing
  };

  // ---- in the tick ----

  /// Where to write the point of this tick.
  ReferencePoint& point(std::uint32_t tick) { return points_[tick % kTicks]; }
  const ReferencePoint& point(std::uint32_t tick) const { return points_[tick % kTicks]; }
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
  Residual& residual(std::uint32_t tick) { return residuals_[tick % kTicks]; }

  // ---- outside the tick ----

  /// A tick of the past, if it is still there when it has been copied. `now()`: the tick now.
  template <class Now>
  bool copy(std::uint32_t tick, ReferencePoint& point, Residual& residual, Now&& now) const {
    point = points_[tick % kTicks];
    residual = residuals_[tick % kTicks];
    std::atomic_signal_fence(std::memory_order_acquire);
    return now() - tick < kTicks;
  }

 private:
  static_assert(kLargestLeadTicks < static_cast<std::int32_t>(kTicks));

  std::uint32_t begin_ = 0;
  std::array<ReferencePoint, kTicks> points_{};
  std::array<Residual, kTicks> residuals_{};
};

}  // namespace slipstack
