// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/control/fixed_motion.h"
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
/// queue runs dry in motion, or on stop(), the axis is braked with constant deceleration.
///
/// Cost of next(): some 45 instructions, 20 more when a segment begins.
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
    braking_ = false;
    taken_.store(pushed_.load(std::memory_order_acquire), std::memory_order_release);
  }

  /// Brakes to standstill; what is queued is forgotten.
  void stop() {
    braking_ = true;
    taken_.store(pushed_.load(std::memory_order_acquire), std::memory_order_release);
  }

  bool standing() const { return velocity_ == 0 && left_ == 0; }
  bool braking() const { return braking_; }
  bool idle() const { return standing() && free() == kCapacity; }
  std::int32_t counts() const { return counts_; }
  /// How often the queue ran dry in motion.
  std::uint32_t underruns() const { return underruns_; }

  /// Position now; then moves on by one tick. `deceleration`: of stop() and of a queue that ran dry, counts
  /// per tick^2 x 2^-48, > 0.
  [[gnu::always_inline]] void next(ReferencePoint& point, const std::int64_t& deceleration) {
    if (braking_) {
      brake(deceleration);
    } else if (left_ == 0) {
      begin_segment(deceleration);
    }
    point.counts = counts_;
    point.fraction = static_cast<float>(static_cast<std::uint32_t>(fraction_ >> 16)) * 0x1p-32F;
    acceleration_ += jerk_;
    velocity_ += acceleration_;
    point.acceleration = from_fixed(acceleration_);
    // The step ahead is the mean velocity over the coming tick; half an increment earlier it is that of now.
    point.velocity = from_fixed(velocity_) - 0.5F * point.acceleration;
    fraction_ += velocity_;
    counts_ = sum(counts_, static_cast<std::int32_t>(fraction_ >> kFractionBits));
    fraction_ &= (std::int64_t{1} << kFractionBits) - 1;
    left_ -= left_ > 0 ? 1 : 0;
  }

 private:
  void begin_segment(const std::int64_t& deceleration) {
    const std::uint32_t at = taken_.load(std::memory_order_relaxed);
    // Writer and tick share a core: what keeps the compiler from changing the order is enough.
    const std::uint32_t pushed = pushed_.load(std::memory_order_relaxed);
    std::atomic_signal_fence(std::memory_order_acquire);
    if (at == pushed) {
      jerk_ = 0;
      acceleration_ = 0;
      if (velocity_ == 0) return;
      braking_ = true;
      ++underruns_;
      brake(deceleration);
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
  void brake(std::int64_t deceleration) {
    jerk_ = 0;
    left_ = 0;
    acceleration_ =
        velocity_ > deceleration ? -deceleration : (velocity_ < -deceleration ? deceleration : -velocity_);
    if (velocity_ == 0) braking_ = false;
  }

  std::int32_t counts_ = 0;
  std::int32_t left_ = 0;
  std::int64_t fraction_ = 0;
  std::int64_t velocity_ = 0;
  std::int64_t acceleration_ = 0;
  std::int64_t jerk_ = 0;
  bool braking_ = false;
  std::uint32_t underruns_ = 0;
  std::atomic<std::uint32_t> pushed_{0};
  std::atomic<std::uint32_t> taken_{0};
  std::array<MotionSegment, kCapacity> queue_{};
};

}  // namespace slipstack
