// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "firmware/control/reference/braking.h"
#include "firmware/control/reference/fixed_motion.h"
#include "firmware/control/reference/motion.h"
#include "firmware/control/reference/segment_queue.h"
#include "firmware/control/streams/tracking.h"
#include "firmware/effects/numerics/approx.h"

namespace slipstack {

/// A trajectory to rest, in the form that the tick plays.
struct MotionPlan {
  static constexpr std::size_t kMost = 16;
  std::array<MotionSegment, kMost> segments{};
  std::size_t size = 0;
};

/// The one reference of the axis. It plays segments of constant jerk: those of a plan, which a trajectory to
/// a target was made into, or those of a queue, into which a stream of set-points is written. Plans may be
/// exchanged in motion: the main loop predicts the state some ticks ahead, plans from there, and the tick
/// takes the plan over at exactly that tick. Whatever happened in between (a stop, a fault) makes the plan
/// void. When the queue runs dry in motion, or on stop(), the reference brakes to rest from whatever velocity
/// and acceleration it has, within the deceleration and jerk of BrakingLimits.
///
/// One writer outside the tick, the tick preempts it; both share a core.
class ReferenceGenerator {
 public:
  ReferenceGenerator() = default;
  // Motion points into the plans.
  ReferenceGenerator(const ReferenceGenerator&) = delete;
  ReferenceGenerator& operator=(const ReferenceGenerator&) = delete;
  ReferenceGenerator(ReferenceGenerator&&) = delete;
  ReferenceGenerator& operator=(ReferenceGenerator&&) = delete;
  ~ReferenceGenerator() = default;

  // ---- the queue, outside the tick ----

  /// Free places in the queue.
  std::uint32_t free() const { return queue_.free(); }
  /// Queues a segment; false when the queue is full.
  bool push(const MotionSegment& segment) { return queue_.push(segment); }

  // ---- plans, outside the tick ----

  /// The state of the motion, and when: a plan from it may begin at `tick`, unless something else happens.
  struct Prediction {
    Motion motion;
    std::uint32_t tick = 0;
    std::uint32_t generation = 0;
    bool standing = false;
  };
  /// `lead` ticks ahead; where the reference stands, at any tick. O(lead).
  Prediction predict(std::uint32_t lead, const BrakingLimits& limits) const {
    Prediction ahead;
    std::uint32_t before = 0;
    bool whole = false;
    // The tick may come in between: once, it is far longer than a copy takes. What is torn all the same is
    // void.
    for (int attempt = 0; attempt < 3 && !whole; ++attempt) {
      before = ticks_.load(std::memory_order_acquire);
      ahead.generation = generation_.load(std::memory_order_relaxed);
      ahead.motion = motion_;
      std::atomic_signal_fence(std::memory_order_acquire);
      whole = ticks_.load(std::memory_order_relaxed) == before;
    }
    if (!whole) --ahead.generation;
    ahead.standing = idle();
    ahead.tick = before + 1 + lead;
    for (std::uint32_t i = 0; i < lead && !ahead.standing; ++i) advance(ahead.motion, limits);
    if (ahead.motion.phase == Motion::Phase::kPlaying && ahead.motion.left == 0) begin_segment(ahead.motion);
    return ahead;
  }

  /// The plan to be written next; no other is waiting from now on.
  MotionPlan& spare_plan() {
    waiting_.store(false, std::memory_order_relaxed);
    std::atomic_signal_fence(std::memory_order_seq_cst);
    return plans_[1 - active_];
  }
  /// Lets the tick take the spare plan over. False when the tick it was made for is past.
  bool arm(const Prediction& from) {
    start_ = from;
    std::atomic_signal_fence(std::memory_order_release);
    waiting_.store(true, std::memory_order_relaxed);
    return from.standing ||
           static_cast<std::int32_t>(from.tick - ticks_.load(std::memory_order_relaxed)) > 0 ||
           !waiting_.load(std::memory_order_relaxed);
  }

  // ---- commands ----

  /// Stands at this position from now on and forgets what was queued.
  void hold(std::int32_t counts) {
    motion_ = {.counts = counts, .taken = queue_.pushed()};
    queue_.free_up_to(motion_.taken);
    void_plan();
  }

  /// Lies where the axis is and moves as it does, counts per tick: from now on until hold() or stop(), which
  /// then brakes from this velocity. In the tick.
  void follow(std::int32_t counts, float velocity) {
    followed_ = {counts, 0.0F, velocity, 0.0F};
    // What a stop begins with: one tick on, by whole counts, with the velocity to 2^-12 of a count per tick.
    const float limited = approx::clamp(velocity, -kLargestRate, kLargestRate);
    motion_.counts = sum(counts, static_cast<std::int32_t>(limited));
    motion_.velocity = static_cast<std::int64_t>(static_cast<std::int32_t>(limited * 0x1p12F)) *
                       (std::int64_t{1} << (kFractionBits - 12));
    motion_.acceleration = motion_.jerk = motion_.fraction = 0;
    motion_.shift = 0;
    motion_.left = 1;  // not at rest, and nothing of the queue
    motion_.phase = Motion::Phase::kFollowing;
    void_plan();
  }

  /// Brakes to standstill from the next point on; what is queued or planned is forgotten.
  void stop() {
    // The next tick does the rest: the main loop may call this as well. Out of a stream advance() brakes.
    if (motion_.phase != Motion::Phase::kTracking) motion_.phase = Motion::Phase::kBraking;
    void_plan();
    motion_.taken = queue_.forget();
  }

  bool standing() const { return motion_.standing(); }
  /// In motion by a plan or a queue.
  bool playing() const { return motion_.phase == Motion::Phase::kPlaying && !standing(); }
  /// In motion behind a stream.
  bool tracking() const { return motion_.phase == Motion::Phase::kTracking && motion_.velocity != 0; }
  /// Towards higher counts, if it moves.
  bool forward() const { return motion_.velocity > 0; }
  bool braking() const { return motion_.phase == Motion::Phase::kBraking; }
  bool idle() const {
    return standing() && free() == SegmentQueue::kCapacity && motion_.next == motion_.end && !plan_waits();
  }
  /// A plan was armed and is neither taken over nor void.
  bool plan_waits() const { return waiting_.load(std::memory_order_relaxed); }
  /// Plans that the tick has taken over since the start.
  std::uint32_t plans_taken() const { return plans_taken_.load(std::memory_order_relaxed); }
  std::int32_t counts() const { return motion_.counts; }
  /// Of a count, 0 to 1.
  float fraction() const { return motion_.fraction_of_count(); }
  /// How often the queue ran dry in motion.
  std::uint32_t underruns() const { return underruns_; }

  /// Position now; then moves on by one tick towards a stream, within `limits`, from whatever state it is in.
  /// Without a call in the next tick it brakes.
  [[gnu::always_inline]] ReferencePoint track(const StreamPoint& stream, const TrackingLimits& limits) {
    ticks_.store(ticks_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (motion_.phase != Motion::Phase::kTracking) [[unlikely]]
      begin_tracking();
    const float last = tracked_step_;
    const float behind = static_cast<float>(difference(stream.counts, motion_.counts)) + stream.offset -
                         stream.step - fraction();
    // Met in a stop that is harder than the stream may be: its path takes that acceleration out, along the
    // jerk limit. Held back from it, the reference would make up for it in a step later.
    const float step = tracking_step(behind, stream.step, last, tracked_change_, limits);
    const ReferencePoint point{motion_.counts, fraction(), 0.5F * (step + last), step - last};
    tracked_step_ = step;
    tracked_change_ = step - last;
    tracked_fastest_ = limits.velocity;
    const std::int64_t before = motion_.velocity;
    motion_.velocity = step_to_fixed(step);
    motion_.acceleration = motion_.velocity - before;
    motion_.move();
    return point;
  }

  /// Position now; then moves on by one tick. `limits`: of stop() and of a queue that ran dry.
  [[gnu::always_inline]] ReferencePoint next(const BrakingLimits& limits) {
    ticks_.store(ticks_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (waiting_.load(std::memory_order_relaxed)) [[unlikely]]
      take_over();
    if (motion_.phase == Motion::Phase::kFollowing) return followed_;
    const bool played = motion_.phase == Motion::Phase::kPlaying;
    const ReferencePoint point = advance(motion_, limits);
    if (played && braking()) ++underruns_;
    queue_.free_up_to(motion_.taken);
    return point;
  }

 private:
  // Inlined: the tick has one call of it.
  [[gnu::always_inline]] ReferencePoint advance(Motion& motion, const BrakingLimits& limits) const {
    if (motion.phase == Motion::Phase::kPlaying && motion.left == 0) begin_segment(motion);
    if (motion.phase == Motion::Phase::kTracking) [[unlikely]]
      motion.leave_stream(limits, tracked_fastest_);
    if (motion.phase == Motion::Phase::kBraking) motion.brake(limits);
    return motion.step();
  }

  // A stream takes over: nothing that was planned or queued is played after it.
  void begin_tracking() {
    motion_.phase = Motion::Phase::kTracking;
    tracked_change_ = from_fixed(shifted_down(motion_.acceleration, motion_.shift));
    motion_.left = 0;
    motion_.jerk = 0;
    motion_.shift = 0;
    motion_.next = motion_.end;
    tracked_step_ = from_fixed(motion_.velocity);
    void_plan();
    motion_.taken = queue_.forget();
  }

  // With 30 binary places: |counts| < kLargestRate, of which a float has no more.
  static std::int64_t step_to_fixed(float counts) {
    const auto whole = static_cast<std::int32_t>(counts);
    const auto rest = static_cast<std::int32_t>((counts - static_cast<float>(whole)) * 0x1p30F);
    return whole * (std::int64_t{1} << kFractionBits) + rest * (std::int64_t{1} << (kFractionBits - 30));
  }

  void void_plan() {
    generation_.store(generation_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  // A plan that was made for this tick, and that nothing has made void.
  void take_over() {
    std::atomic_signal_fence(std::memory_order_acquire);
    const auto early = static_cast<std::int32_t>(start_.tick - ticks_.load(std::memory_order_relaxed));
    const bool is_void = start_.generation != generation_.load(std::memory_order_relaxed);
    if (!is_void && !start_.standing && early > 0) return;
    waiting_.store(false, std::memory_order_relaxed);
    if (is_void || (!start_.standing && early < 0)) return;
    plans_taken_.store(plans_taken_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    active_ = 1 - active_;
    motion_.next = plans_[active_].segments.data();
    motion_.end = motion_.next + plans_[active_].size;
    motion_.left = 0;
    motion_.phase = Motion::Phase::kPlaying;
  }

  void begin_segment(Motion& motion) const {
    if (motion.next != motion.end) return motion.begin(*motion.next++);
    if (const MotionSegment* queued = queue_.after(motion.taken)) {
      ++motion.taken;
      return motion.begin(*queued);
    }
    motion.jerk = 0;
    if (motion.velocity != 0 || motion.acceleration != 0) motion.phase = Motion::Phase::kBraking;
  }

  Motion motion_;
  ReferencePoint followed_;
  float tracked_step_ = 0.0F;
  float tracked_change_ = 0.0F;
  float tracked_fastest_ = 0.0F;
  std::uint32_t underruns_ = 0;
  std::atomic<std::uint32_t> ticks_{0};
  std::atomic<std::uint32_t> generation_{0};  // of the motion: counts what no prediction has foreseen
  std::atomic<bool> waiting_{false};
  std::atomic<std::uint32_t> plans_taken_{0};
  Prediction start_;
  std::size_t active_ = 0;
  std::array<MotionPlan, 2> plans_{};
  SegmentQueue queue_;
};

}  // namespace slipstack
