// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/control/bounds/position_range.h"
#include "firmware/control/reference/motion.h"
#include "firmware/control/reference/motion_limits.h"
#include "firmware/control/streams/set_point_periods.h"
#include "firmware/control/streams/set_point_spline.h"
#include "firmware/control/streams/stream_path.h"
#include "firmware/control/streams/sync_clock.h"
#include "firmware/control/streams/tracking.h"

namespace slipstack {

/// Cyclic synchronous position and velocity, from the bus to the reference in one direction:
///
///   SYNC n and its set-point (main loop) -> its period, by time and order -> spline -> path within the
///   limits
///   -> segments, one a period; segment of the period (tick) -> place of the stream in this tick -> reference
///
/// Periods are those of SyncClock. Set-point n is expected at n and its segment begins at n + 1: one period
/// is buffered, between one and two as jitter has it. The reference passes set-point n at n + 3. With each
/// come the segments of the next two, extrapolated: they are replaced when their set-points arrive in time. A
/// third that is missing ends the stream, and the reference brakes. It is followed again when four set-points
/// in a row are there, from wherever the reference is by then. What a stream asks for beyond the limits of
/// velocity, acceleration, jerk and range its path holds back (stream_path.h).
///
/// Set-points of velocity are summed up by the same path. They need no others before them: a stream begins
/// with the first, in the state that the reference will have when its first segment begins.
class CyclicPosition {
 public:
  static constexpr std::uint32_t kBridged = 2;
  /// Counts that the axis may move in a period, at most: what the spline's arithmetic holds.
  static constexpr float kLargestReach = 2.4e7F;

  // ---- outside the tick ----

  /// The period of SYNC.
  void set_period(float ticks, float tick_s) { clock_.set_period(ticks, tick_s); }

  /// In every pass of the main loop, after this tick.
  void poll(std::uint32_t tick) { clock_.follow(tick); }

  /// What bounds a path, after set_period(); counts and ticks. `rounding`: of the jerk, counts per period^3.
  StreamPath::Limits path_limits(const MotionLimits& limits, const PositionRange& range,
                                 float rounding) const {
    const float period = clock_.period_ticks();
    const float square = period * period;
    return {.velocity = within_reach(limits.velocity * period),
            .speeding = within_reach(limits.acceleration * square),
            .slowing = within_reach(limits.deceleration * square),
            .jerk = within_reach(limits.jerk * square * period),
            .rounding = rounding,
            .range = range};
  }
  /// What the rounding of set-points to whole counts makes of the jerk of their spline, counts per period^3:
  /// 5.8, by the sum of the weights of its set-points.
  static constexpr float kRounding = 6.0F;

  /// From now on the reference follows the stream, as soon as there is one.
  void start() {
    started_ = true;
    ended_.store(false, std::memory_order_relaxed);
    forget();
  }
  /// The stream is left; the reference brakes, unless something else moves it.
  void stop() {
    started_ = false;
    forget();
  }

  /// A SYNC has come after this tick, and made `target` the set-point if it `has_target`. `path`: what leads
  /// the reference, within its limits. `ahead(lead)`: Motion of the reference so many ticks from now.
  template <class Ahead>
  void sync(std::uint32_t tick, bool has_target, std::int32_t target, StreamPath& path, const Ahead& ahead) {
    const std::uint32_t by_time = clock_.sync(tick);
    if (!may_take(by_time, has_target, ahead)) return;
    const SetPointPeriods::Place place =
        periods_.place(by_time, target, static_cast<std::int32_t>(kLargestReach));
    spline_.put(place.period, place.counts);
    const SyncClock::Phase now = clock_.at(tick);
    const std::uint32_t begun = now.period - 1;
    if (ran_out(begun)) leave();
    count_bridged(place.period, begun);
    const bool streamed = joined_;
    if (!join(place.period)) return;
    if (!streamed) {
      const bool too_late = static_cast<std::int32_t>(place.period - begun) <= 0;
      const std::uint32_t first = too_late ? begun + 1 : place.period;
      path.start(first, begin_of(first, now, ahead));
    }
    const auto bend = static_cast<std::int32_t>(path.limits().speeding) + 1;
    make_segments(place.period, begun, path, [&](std::uint32_t period) {
      if (period != place.period) static_cast<void>(spline_.extrapolate(period, bend));
      if (static_cast<std::int32_t>(period - begun) <= 0) return;
      spline_.lean(period, bend);
      const std::uint64_t now_at = spline_.place(period);
      const std::uint64_t before_at = spline_.place(period - 1);
      if (period != place.period) return path.extrapolate_place(period, now_at, before_at);
      path.put_place(period, now_at, before_at);
    });
  }

  /// The same with a set-point of velocity, counts per tick.
  template <class Ahead>
  void sync_velocity(std::uint32_t tick, bool has_target, float velocity, StreamPath& path,
                     const Ahead& ahead) {
    const std::uint32_t by_time = clock_.sync(tick);
    if (!may_take(by_time, has_target, ahead)) return;
    const SyncClock::Phase now = clock_.at(tick);
    const std::uint32_t begun = now.period - 1;
    const std::uint32_t newest = period_of_velocity(by_time, now);
    count_bridged(newest, begun);
    if (joined_ && newest - newest_ > kBridged + 1) leave();
    // Of SYNCs that were held back and come together, the last one tells when a stream begins.
    if (joined_ && began_ == tick && newest != newest_) {
      empty_slots();
      in_a_row_ = 0;
    }
    // Until its first segment begins, each SYNC tells better when that is.
    if (!joined_ || newest != newest_) ++in_a_row_;
    if (in_a_row_ == 1 && static_cast<std::int32_t>(newest - begun) > 0) {
      path.start(newest, begin_of(newest, now, ahead));
      began_ = tick;
    }
    newest_ = newest;
    joined_ = true;
    streaming_.store(true, std::memory_order_release);
    make_segments(newest, begun, path, [&](std::uint32_t period) {
      if (static_cast<std::int32_t>(period - begun) <= 0) return;
      if (period != newest) return path.extrapolate_velocity(period);
      path.put_velocity(period, velocity * clock_.period_ticks());
    });
  }

  /// Whether the reference follows the stream.
  bool following() const { return following_.load(std::memory_order_relaxed); }
  const SyncClock& clock() const { return clock_; }
  /// Set-points that were extrapolated, and streams that ended because too many were missing or SYNC lost its
  /// lock.
  std::uint32_t bridged() const { return bridged_; }
  std::uint32_t gaps() const { return gaps_; }

  // ---- in the tick ----

  /// In each tick; true while there is a stream: point() is where.
  [[gnu::always_inline]] bool step(std::uint32_t tick) {
    if (!streaming_.load(std::memory_order_relaxed)) return false;
    const SyncClock::Phase now = clock_.at(tick);
    bool follows = following();
    if (now.period != period_) {
      period_ = now.period;
      follows = begin_period(now.period - 1);
      following_.store(follows, std::memory_order_relaxed);
    }
    fraction_ = now.fraction;
    return follows;
  }
  StreamPoint point() const { return segment_->at(fraction_, clock_.rate()); }
  /// The stream leads where the axis must not go: the reference brakes, and follows again from rest.
  [[gnu::noinline]] void end() {
    if (!streaming_.load(std::memory_order_relaxed)) return;
    streaming_.store(false, std::memory_order_relaxed);
    following_.store(false, std::memory_order_relaxed);
    ended_.store(true, std::memory_order_relaxed);
  }

 private:
  static constexpr std::uint32_t kSlots = 8;

  // Two places for the segment of a period, so that the one in use is never written to.
  struct Slot {
    std::array<StreamSegment, 2> made;
    std::atomic<std::uint32_t> in_use{0};  // twice the period, plus which of the two
  };

  static float within_reach(float counts) { return approx::clamp(counts, 0.0F, kLargestReach); }

  template <class Ahead>
  bool may_take(std::uint32_t by_time, bool has_target, const Ahead& ahead) {
    if (!clock_.locked() || played_out(by_time)) end_unasked();
    if (!started_ || !clock_.locked() || !has_target) return false;
    if (!ended_.load(std::memory_order_relaxed)) return true;
    // The tick has ended it.
    if (!ahead(0).standing()) return false;
    ended_.store(false, std::memory_order_relaxed);
    forget();
    return true;
  }

  // The reference brakes if it has followed. Where set-points are missing, the tick has counted that already.
  void end_unasked() {
    const bool followed = following();
    forget();
    // From now on the tick counts none.
    gaps_ += followed ? 1 : 0;
  }

  // The last segment of a stream is long over: it must be gone before its number comes round.
  bool played_out(std::uint32_t period) const {
    const auto since = static_cast<std::int32_t>(period - newest_);
    return since > static_cast<std::int32_t>(kSlots) && streaming_.load(std::memory_order_relaxed);
  }

  // The tick has come to a period without a segment: the reference brakes.
  bool ran_out(std::uint32_t begun) const {
    return joined_ && static_cast<std::int32_t>(newest_ + kBridged + 1 - begun) <= 0;
  }
  // Nothing of the stream so far is played any more. Its last segments, where they were not over yet, are
  // left for the stop that a prediction begins with.
  void leave() {
    const bool early = following();
    following_.store(false, std::memory_order_relaxed);
    // From now on the tick counts none.
    gaps_ += early ? 1 : 0;
    empty_slots();
    in_a_row_ = 0;
    joined_ = false;
  }

  // By time. A SYNC that came between two periods was late or held back: its set-point is for the first one
  // to be played yet.
  std::uint32_t period_of_velocity(std::uint32_t by_time, const SyncClock::Phase& now) const {
    constexpr std::uint32_t kOnTime = 0x40000000;  // a quarter of a period
    const auto since = static_cast<std::int32_t>(by_time - newest_);
    if (!joined_ || (since >= 0 && now.fraction + kOnTime < 2 * kOnTime)) return by_time;
    if (since <= 0) return newest_;
    const std::uint32_t next = newest_ + 1;
    const std::uint32_t first = static_cast<std::int32_t>(next - now.period) > 0 ? next : now.period;
    return static_cast<std::int32_t>(by_time - first) > 0 ? first : by_time;
  }

  // The state of the reference when the segment of `period` begins. A prediction of many ticks takes long;
  // what is beyond is constant velocity.
  template <class Ahead>
  StreamPath::State begin_of(std::uint32_t period, const SyncClock::Phase& now, const Ahead& ahead) const {
    constexpr float kFarthest_ticks = 256.0F;
    const auto periods = static_cast<float>(static_cast<std::int32_t>(period + 1 - now.period));
    const float left = clock_.ticks_until(periods - static_cast<float>(now.fraction) * 0x1p-32F);
    const auto lead = static_cast<std::uint32_t>(approx::clamp(left, 0.0F, kFarthest_ticks));
    const Motion then = ahead(lead);
    const float rest = left - static_cast<float>(lead);
    const float acceleration = rest < 1.0F ? from_fixed(shifted_down(then.acceleration, then.shift)) : 0.0F;
    // A motion has the step of its last tick: the velocity in the middle of that.
    const float velocity = from_fixed(then.velocity) + (0.5F + rest) * acceleration;
    const float beyond = rest * (velocity - 0.5F * rest * acceleration);
    const auto whole = static_cast<std::int32_t>(beyond);
    const float ticks = 1.0F / clock_.rate_in(left);
    return {sum(then.counts, whole), then.fraction_of_count() + (beyond - static_cast<float>(whole)),
            velocity * ticks, acceleration * ticks * ticks};
  }

  // The tick looks at nothing that was made: neither now nor when those periods come.
  void forget() {
    streaming_.store(false, std::memory_order_release);
    following_.store(false, std::memory_order_relaxed);
    empty_slots();
    periods_.reset();
    in_a_row_ = 0;
    joined_ = false;
  }
  void empty_slots() {
    for (std::uint32_t i = 0; i < kSlots; ++i) {
      const std::uint32_t which = slots_[i].in_use.load(std::memory_order_relaxed) & 1U;
      // A period that is never looked for in this slot, whatever the clock says.
      slots_[i].in_use.store(2 * (i ^ 1U) + which, std::memory_order_relaxed);
    }
  }

  // Whether there is a stream with this set-point: four in a row begin one, three missing end it.
  bool join(std::uint32_t newest) {
    const std::uint32_t since = newest - newest_;
    if (since == 0 && in_a_row_ > 0) return joined_;
    in_a_row_ = since == 1 ? in_a_row_ + 1 : 1;
    newest_ = newest;
    if (since > kBridged + 1) joined_ = false;
    if (joined_ || in_a_row_ < 4) return joined_;
    joined_ = true;
    spline_.start(newest);
    streaming_.store(true, std::memory_order_release);
    return true;
  }

  // Before join(): those that never came between the last one and this, and this one if it is too late.
  void count_bridged(std::uint32_t newest, std::uint32_t begun) {
    const std::uint32_t since = newest - newest_;
    if (!joined_ || since - 1 > kBridged) return;
    bridged_ += since - 1 + (static_cast<std::int32_t>(newest - begun) <= 0 ? 1U : 0U);
  }

  // The segments that have not begun: that of the newest set-point and those that bridge the next ones.
  template <class Put>
  void make_segments(std::uint32_t newest, std::uint32_t begun, const StreamPath& path, const Put& put) {
    for (std::uint32_t period = newest; period != newest + kBridged + 1; ++period) {
      put(period);
      if (static_cast<std::int32_t>(period - begun) <= 0) continue;
      Slot& slot = slots_[period % kSlots];
      const std::uint32_t other = (slot.in_use.load(std::memory_order_relaxed) & 1U) ^ 1U;
      slot.made[other] = path.segment(period);
      slot.in_use.store(2 * period + other, std::memory_order_release);
    }
  }

  // The segment that ends two periods before the set-point of `newest`. False without one.
  bool begin_period(std::uint32_t newest) {
    const Slot& slot = slots_[newest % kSlots];
    const std::uint32_t in_use = slot.in_use.load(std::memory_order_acquire);
    if (((in_use ^ (2 * newest)) & ~1U) != 0) {
      gaps_ += following() ? 1 : 0;
      return false;
    }
    segment_ = &slot.made[in_use & 1U];
    return true;
  }

  SyncClock clock_;
  // Outside the tick.
  SetPointPeriods periods_;
  SetPointSpline spline_;
  std::uint32_t newest_ = 0;
  std::uint32_t in_a_row_ = 0;
  std::uint32_t began_ = 0;  // the tick in which the stream of velocities began
  bool joined_ = false;
  bool started_ = false;
  std::uint32_t bridged_ = 0;
  // From there to the tick, and back.
  std::array<Slot, kSlots> slots_;
  std::atomic<bool> streaming_{false};
  std::atomic<bool> following_{false};
  std::atomic<bool> ended_{false};  // by the tick
  // In the tick.
  const StreamSegment* segment_ = nullptr;
  std::uint32_t period_ = 0;
  std::uint32_t fraction_ = 0;
  std::uint32_t gaps_ = 0;
};

}  // namespace slipstack
