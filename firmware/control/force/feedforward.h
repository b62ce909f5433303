// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/force/state_estimate.h"
#include "firmware/control/homing/position_reference.h"
#include "firmware/control/reference/reference.h"
#include "firmware/effects/model.h"

namespace slipstack {

/// Time since the start. The counter of ticks wraps after 119 h at 10 kHz, the time must not: drift would
/// begin anew. In the main loop, more often than the counter wraps: what follows time is slow.
class UpTime {
 public:
  // In two parts, because 64 bits to float is a call of a library on the target.
  float at(std::uint32_t tick, float tick_s) {
    if (tick < last_tick_) wraps_ += 0x10000U;
    last_tick_ = tick;
    return (static_cast<float>(wraps_ + (tick >> 16)) * 65536.0F + static_cast<float>(tick & 0xFFFFU)) *
           tick_s;
  }

 private:
  std::uint32_t last_tick_ = 0;
  std::uint32_t wraps_ = 0;  // of the counter, in units of 2^16 ticks
};

/// The friction model on the reference: the force that moves the axis as asked, if the model is right.
class FeedForward {
 public:
  /// Constants of the tick; made outside it.
  struct Scales {
    float resolution_m = 1.0F;
    float mps_per_count = 0.0F;
    float mps2_per_count = 0.0F;
    std::int32_t shift_up = 0;  ///< displacement is counts x 2^up / 2^down; one of the two is zero
    std::int32_t shift_down = 0;
    float steps_per_count = 0.0F;  ///< 2^up / 2^down
    float steps_per_m = 0.0F;
    float ahead = 0.5F;     ///< of the tick; more or less where a delay is no whole number of them
    std::int32_t band = 0;  ///< dead band of the observer, steps
    float rest = 0.0F;      ///< a reference below this speed rests, counts per tick; 0: it never does
  };

  /// Where the hysteresis sees the reference, in its own steps: in the middle of the tick over which its
  /// force is held. At the tick itself, the force of a motion that has just turned round would be late by
  /// half a tick, where it changes most. Velocity and place on the rail change too little in a tick to
  /// matter.
  static std::int32_t displacement(const Scales& scale, const ReferencePoint& at) {
    const float beyond = at.fraction + scale.ahead * at.velocity;
    return displacement(scale, at.counts) + static_cast<std::int32_t>(beyond * scale.steps_per_count);
  }

  /// The same of the axis.
  static std::int32_t displacement(const Scales& scale, const StateEstimate& estimate) {
    return displacement(scale, estimate.counts()) +
           static_cast<std::int32_t>(estimate.offset_m() * scale.steps_per_m);
  }

  /// The same of whole counts, as the encoder has them.
  static std::int32_t displacement(const Scales& scale, std::int32_t counts) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(counts) << scale.shift_up) >>
           scale.shift_down;
  }

  // ---- where the hysteresis is: before each step() ----

  /// Here from now on.
  void start(const Scales& scale, std::int32_t counts) {
    place_ = reference_ = axis_ = displacement(scale, counts);
    rests_ = true;
  }
  /// It moves with the reference; where that rests, or lies where the axis is (`follows`), with the axis, by
  /// what the counts do beyond the dead band, as a play operator has it: noise within it moves nothing. The
  /// play begins where the estimate of the tick before has the axis: were it the middle of the count, an axis
  /// that comes to rest near its edge and flickers over it would seem to have moved by half a count, where
  /// the friction is stiffest.
  void observe(const Scales& scale, const ReferencePoint& at, std::int32_t counts,
               const StateEstimate& estimate, bool follows) {
    const std::int32_t now = displacement(scale, at);
    std::int32_t moved = difference(now, reference_);
    const bool rests = follows || approx::absolute(at.velocity) < scale.rest;
    correction_ = 0.0F;
    if (rests) {
      const std::int32_t before = axis_;
      axis_ =
          played(rests_ ? before : displacement(scale, estimate), displacement(scale, counts), scale.band);
      if (rests_) {
        moved = difference(axis_, before);
        correction_ = 1.0F;
      }
    }
    rests_ = rests;
    place_ = sum(place_, moved);
    reference_ = now;
  }
  /// Where step() finds it, in its own steps.
  std::int32_t place() const { return place_; }

  /// One tick: the force in N at this point of the reference with the dry friction at this level. `reference`
  /// says where on the rail that is.
  float step(FrictionModel<float>& model, const Scales& scale, const ReferencePoint& at, float level,
             const PositionReference& reference) {
    const Sample<float> sample{
        .time_s = 0.0F,  // FrictionModel::refresh()
        .displacement = place_,
        .position_m =
            (static_cast<float>(reference.position_of(at.counts)) + at.fraction) * scale.resolution_m,
        .velocity_mps = at.velocity * scale.mps_per_count,
        .acceleration_mps2 = at.acceleration * scale.mps2_per_count,
        .dry_friction_N = 0.0F,
        .position_weight = reference.weight()};
    const FrictionModel<float>::Force& force = model.advance(sample);
    corrected_N_ = correction_ * level * (force.dry_friction_N - dry_N_);
    dry_N_ = force.dry_friction_N;
    return force.total_N + (level - 1.0F) * dry_N_;
  }

  /// The dry friction of the last step, at level 1.
  float dry_N() const { return dry_N_; }
  /// What the observer's correction changed in the last step, N.
  float corrected_N() const { return corrected_N_; }

 private:
  // `from` moved as little as brings it within the band about `to`.
  static std::int32_t played(std::int32_t from, std::int32_t to, std::int32_t band) {
    std::int32_t ahead = difference(from, to);
    ahead = ahead < -band ? -band : ahead;
    ahead = ahead > band ? band : ahead;
    return sum(to, ahead);
  }

  float dry_N_ = 0.0F;
  float correction_ = 0.0F;  // 1 in a tick in which the axis moves the hysteresis
  float corrected_N_ = 0.0F;
  // In steps of the hysteresis.
  std::int32_t reference_ = 0;
  std::int32_t axis_ = 0;   // within the dead band about the counts; at rest
  std::int32_t place_ = 0;  // of the hysteresis
  bool rests_ = true;       // the reference did in the last tick, or lay where the axis is
};

}  // namespace slipstack
