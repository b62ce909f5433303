// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/control/set_point_periods.h"
#include "firmware/control/set_point_spline.h"
#include "firmware/control/sync_clock.h"
#include "firmware/control/tracking.h"

namespace slipstack {

/// Cyclic synchronous position, from the bus to the reference in one direction:
///
///   SYNC n and its set-point (main loop) -> its period, by time and order -> buffer
///   buffer (tick, where period n + 1 ends) -> spline -> place of the stream in this tick -> reference
///
/// Periods are those of SyncClock. Set-point n is expected at n and needed at n + 1: one period is buffered,
/// between one and two as jitter has it. The reference passes it at n + 3. One or two set-points that are
/// missing when they are needed are extrapolated; a third ends the stream, and the reference brakes. It is
/// followed again when four set-points in a row are there, from wherever the reference is by then
/// (tracking_step()).
class CyclicPosition {
 public:
  static constexpr std::int32_t kBridged = 2;
  /// Counts that the axis may move in a period, at most: what the spline's arithmetic holds.
  static constexpr float kLargestReach = 2.4e7F;

  // ---- outside the tick ----

  /// The period of SYNC and what the axis may do, counts and ticks.
  void set_period(float ticks, float tick_s, float velocity, float acceleration) {
    clock_.set_period(ticks, tick_s);
    const float period = clock_.period_ticks();
    reach_ = static_cast<std::int32_t>(approx::clamp(velocity * period, 0.0F, kLargestReach)) + 1;
    const float bend = approx::clamp(acceleration * period * period, 0.0F, kLargestReach);
    bend_.store(static_cast<std::int32_t>(bend) + 1, std::memory_order_relaxed);
  }

  /// From now on the reference follows the stream, as soon as there is one.
  void start() {
    started_ = true;
    periods_.reset();
  }
  /// The stream is left; the reference brakes, unless something else moves it.
  void stop() {
    started_ = false;
    running_.store(false, std::memory_order_relaxed);
  }

  /// A SYNC has come, and made `target` the set-point if it `has_target`.
  void sync(bool has_target, std::int32_t target) {
    const std::uint32_t by_time = clock_.sync();
    const bool running = started_ && clock_.locked();
    running_.store(running, std::memory_order_relaxed);
    if (!running || !has_target) return;
    const SetPointPeriods::Place place = periods_.place(by_time, target, reach_);
    Slot& slot = buffer_[place.period % kSlots];
    slot.counts.store(place.counts, std::memory_order_relaxed);
    slot.period.store(place.period, std::memory_order_release);
  }

  /// Whether the reference follows the stream.
  bool following() const { return following_.load(std::memory_order_relaxed); }
  const SyncClock& clock() const { return clock_; }
  /// Set-points that were extrapolated, and streams that ended because too many were missing.
  std::uint32_t bridged() const { return bridged_; }
  std::uint32_t gaps() const { return gaps_; }

  // ---- in the tick ----

  /// Moves on by one tick; true while there is a stream: point() is where it is at the end of the tick.
  bool step() {
    const SyncClock::Phase now = clock_.advance();
    if (now.period != period_) {
      period_ = now.period;
      begin_period(now.period - 1);
    }
    if (state_ == State::kWaiting) return false;
    const SetPointSpline::Place at = spline_.at(now.fraction);
    const std::int32_t moved = difference(at.counts, point_.counts);
    const std::int64_t step = static_cast<std::int64_t>(moved) * (std::int64_t{1} << 32) +
                              (static_cast<std::int64_t>(at.fraction) - point_.fraction);
    point_ = {at.counts, at.fraction, step * (std::int64_t{1} << (kFractionBits - 32))};
    // The first point has no step that leads to it.
    const bool known = state_ == State::kFollowing;
    state_ = State::kFollowing;
    following_.store(known, std::memory_order_relaxed);
    return known;
  }
  const StreamPoint& point() const { return point_; }

 private:
  static constexpr std::uint32_t kSlots = 8;

  struct Slot {
    std::atomic<std::uint32_t> period{0x80000000U};  // far from the first ones
    std::atomic<std::int32_t> counts{0};
  };
  enum class State : std::uint8_t { kWaiting, kFound, kFollowing };

  // Whether the set-point of this period has come.
  bool take(std::uint32_t period, std::int32_t& counts) const {
    const Slot& slot = buffer_[period % kSlots];
    if (slot.period.load(std::memory_order_acquire) != period) return false;
    counts = slot.counts.load(std::memory_order_relaxed);
    return true;
  }

  // Set-point `newest` is needed now.
  void begin_period(std::uint32_t newest) {
    if (!running_.load(std::memory_order_relaxed)) return end();
    if (state_ == State::kWaiting) return find(newest);
    // What came late still tells the spline about velocity and acceleration.
    static_cast<void>(take(newest - 1, spline_.set_point(0)));
    static_cast<void>(take(newest - 2, spline_.set_point(1)));
    std::int32_t counts = 0;
    const std::int32_t bend = bend_.load(std::memory_order_relaxed);
    if (take(newest, counts)) {
      missing_ = 0;
    } else if (++missing_ <= kBridged) {
      counts = spline_.extrapolated(bend);
      ++bridged_;
    } else {
      ++gaps_;
      return end();
    }
    spline_.append(counts, bend);
  }

  void find(std::uint32_t newest) {
    std::array<std::int32_t, 4> last{};
    for (std::uint32_t i = 0; i < last.size(); ++i) {
      if (!take(newest - i, last[i])) return;
    }
    spline_.start(last);
    missing_ = 0;
    state_ = State::kFound;
  }

  void end() {
    state_ = State::kWaiting;
    following_.store(false, std::memory_order_relaxed);
  }

  SyncClock clock_;
  // Outside the tick.
  SetPointPeriods periods_;
  std::int32_t reach_ = 1;
  bool started_ = false;
  // From there to the tick, and back.
  std::array<Slot, kSlots> buffer_{};
  std::atomic<bool> running_{false};
  std::atomic<bool> following_{false};
  std::atomic<std::int32_t> bend_{1};
  // In the tick.
  SetPointSpline spline_;
  StreamPoint point_;
  std::uint32_t period_ = 0;
  std::int32_t missing_ = 0;
  State state_ = State::kWaiting;
  std::uint32_t bridged_ = 0;
  std::uint32_t gaps_ = 0;
};

}  // namespace slipstack
