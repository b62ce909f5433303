// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/control/braking.h"
#include "firmware/control/fixed_motion.h"
#include "firmware/control/tracking.h"
#include "firmware/effects/approx.h"
#include "firmware/friction/displacement.h"

namespace slipstack {

/// Where the axis shall be at one tick.
struct ReferencePoint {
  std::int32_t counts = 0;    ///< whole counts
  float fraction = 0.0F;      ///< of a count, 0 to 1
  float velocity = 0.0F;      ///< counts per tick
  float acceleration = 0.0F;  ///< counts per tick^2, mean over the tick that begins here
};

/// Plays motion segments one after the other. One writer outside the tick pushes, the tick takes. When the
/// queue runs dry in motion, or on stop(), the reference brakes to rest from whatever velocity and
/// acceleration it has, within the deceleration and jerk of BrakingLimits.
class ReferenceGenerator {
 public:
  static constexpr std::uint32_t kCapacity = 16;

  /// Free places in the queue.
  std::uint32_t free() const {
    return kCapacity - (pushed_.load(std::memory_order_relaxed) - taken_.load(std::memory_order_acquire));
  }

  /// Queues a segment; false when the queue is full or the axis brakes. Outside the tick.
  bool push(const MotionSegment& segment) {
    if (free() == 0 || segment.ticks <= 0) return false;
    const std::uint32_t at = pushed_.load(std::memory_order_relaxed);
    queue_[at % kCapacity] = segment;
    pushed_.store(at + 1, std::memory_order_release);
    return true;
  }

  /// Stands at this position from now on and forgets what was queued.
  void hold(std::int32_t counts) {
    counts_ = counts;
    fraction_ = 0;
    velocity_ = acceleration_ = jerk_ = 0;
    left_ = 0;
    phase_ = Phase::kPlaying;
    forget_queue();
  }

  /// Lies where the axis is and moves as it does, counts per tick: from now on until hold() or stop(), which
  /// then brakes from this velocity. In the tick.
  void follow(std::int32_t counts, float velocity) {
    counts_ = counts;
    followed_velocity_ = velocity;
    left_ = 1;  // not at rest, and nothing of the queue
    phase_ = Phase::kFollowing;
  }

  /// Brakes to standstill from the next point on; what is queued is forgotten.
  void stop() {
    // The next tick does the rest: the main loop may call this as well.
    if (phase_ == Phase::kPlaying || phase_ == Phase::kTracking) phase_ = Phase::kBraking;
    if (phase_ == Phase::kFollowing) phase_ = Phase::kLeaving;
    forget_queue();
  }

  bool standing() const { return velocity_ == 0 && acceleration_ == 0 && left_ == 0; }
  bool braking() const { return phase_ == Phase::kBraking || phase_ == Phase::kLeaving; }
  bool idle() const { return standing() && free() == kCapacity; }
  std::int32_t counts() const { return counts_; }
  /// Of a count, 0 to 1.
  float fraction() const {
    return static_cast<float>(static_cast<std::uint32_t>(fraction_ >> (kFractionBits - 32))) * 0x1p-32F;
  }
  /// How often the queue ran dry in motion.
  std::uint32_t underruns() const { return underruns_; }

  /// Position now; then moves on by one tick towards a stream, within `limits`, from whatever state it is in.
  /// Without a call in the next tick it brakes.
  [[gnu::always_inline]] ReferencePoint track(const StreamPoint& stream, const TrackingLimits& limits) {
    if (phase_ != Phase::kTracking) {
      phase_ = Phase::kTracking;
      left_ = 0;
      jerk_ = 0;
      tracked_step_ = from_fixed(velocity_);
    }
    const float last = tracked_step_;
    const float behind =
        static_cast<float>(difference(stream.counts, counts_)) + stream.offset - stream.step - fraction();
    const float step = tracking_step(behind, stream.step, last, limits);
    const ReferencePoint point{counts_, fraction(), 0.5F * (step + last), step - last};
    tracked_step_ = step;
    const std::int64_t before = velocity_;
    velocity_ = step_to_fixed(step);
    acceleration_ = velocity_ - before;
    move();
    return point;
  }

  /// Position now; then moves on by one tick. `limits`: of stop() and of a queue that ran dry.
  [[gnu::always_inline]] ReferencePoint next(const BrakingLimits& limits) {
    if (phase_ == Phase::kFollowing) return {counts_, 0.0F, followed_velocity_, 0.0F};
    if (phase_ == Phase::kTracking) phase_ = Phase::kBraking;
    if (phase_ == Phase::kLeaving) begin_from_followed();
    if (phase_ == Phase::kPlaying && left_ == 0) begin_segment();
    if (phase_ == Phase::kBraking) brake(limits);
    return advance();
  }

 private:
  enum class Phase : std::uint8_t { kPlaying, kFollowing, kLeaving, kTracking, kBraking };

  ReferencePoint advance() {
    ReferencePoint point;
    point.counts = counts_;
    point.fraction = fraction();
    acceleration_ += jerk_;
    velocity_ += acceleration_;
    point.acceleration = from_fixed(acceleration_);
    // The step ahead is the mean velocity over the coming tick; half an increment earlier it is that of now.
    point.velocity = from_fixed(velocity_) - 0.5F * point.acceleration;
    move();
    left_ -= left_ > 0 ? 1 : 0;
    return point;
  }

  [[gnu::always_inline]] void move() {
    fraction_ += velocity_;
    counts_ = sum(counts_, static_cast<std::int32_t>(fraction_ >> kFractionBits));
    fraction_ &= (std::int64_t{1} << kFractionBits) - 1;
  }

  // With 30 binary places: |counts| < kLargestRate, of which a float has no more.
  static std::int64_t step_to_fixed(float counts) {
    const auto whole = static_cast<std::int32_t>(counts);
    const auto rest = static_cast<std::int32_t>((counts - static_cast<float>(whole)) * 0x1p30F);
    return whole * (std::int64_t{1} << kFractionBits) + rest * (std::int64_t{1} << (kFractionBits - 30));
  }

  // The followed point is that of the last tick: one tick on, by whole counts, with its velocity to 2^-12 of
  // a count per tick.
  void begin_from_followed() {
    const float velocity = approx::clamp(followed_velocity_, -kLargestRate, kLargestRate);
    counts_ = sum(counts_, static_cast<std::int32_t>(velocity));
    velocity_ = static_cast<std::int64_t>(static_cast<std::int32_t>(velocity * 0x1p12F)) *
                (std::int64_t{1} << (kFractionBits - 12));
    acceleration_ = jerk_ = fraction_ = 0;
    phase_ = Phase::kBraking;
  }

  // Writer and tick share a core: nothing but the order of the compiler matters.
  void forget_queue() {
    const std::uint32_t pushed = pushed_.load(std::memory_order_relaxed);
    std::atomic_signal_fence(std::memory_order_acq_rel);
    taken_.store(pushed, std::memory_order_relaxed);
  }

  void begin_segment() {
    const std::uint32_t at = taken_.load(std::memory_order_relaxed);
    // Writer and tick share a core: what keeps the compiler from changing the order is enough.
    const std::uint32_t pushed = pushed_.load(std::memory_order_relaxed);
    std::atomic_signal_fence(std::memory_order_acquire);
    if (at == pushed) {
      jerk_ = 0;
      if (velocity_ == 0 && acceleration_ == 0) return;
      phase_ = Phase::kBraking;
      ++underruns_;
      return;
    }
    const MotionSegment& segment = queue_[at % kCapacity];
    left_ = segment.ticks;
    velocity_ = segment.velocity;
    acceleration_ = segment.acceleration;
    jerk_ = segment.jerk;
    if (segment.sets_position) {
      counts_ = segment.start_counts;
      fraction_ = segment.start_fraction;
    }
    std::atomic_signal_fence(std::memory_order_release);
    taken_.store(at + 1, std::memory_order_relaxed);
  }

  // What is queued while the axis brakes waits for the tick after it has come to rest.
  void brake(const BrakingLimits& limits) {
    jerk_ = 0;
    left_ = 0;
    acceleration_ = braking_acceleration(velocity_, acceleration_, limits);
    if (velocity_ == 0 && acceleration_ == 0) phase_ = Phase::kPlaying;
  }

  std::int32_t counts_ = 0;
  std::int32_t left_ = 0;
  std::int64_t fraction_ = 0;
  std::int64_t velocity_ = 0;
  std::int64_t acceleration_ = 0;
  std::int64_t jerk_ = 0;
  Phase phase_ = Phase::kPlaying;
  float followed_velocity_ = 0.0F;
  float tracked_step_ = 0.0F;
  std::uint32_t underruns_ = 0;
  std::atomic<std::uint32_t> pushed_{0};
  std::atomic<std::uint32_t> taken_{0};
  std::array<MotionSegment, kCapacity> queue_{};
};

}  // namespace slipstack
