// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/force/adaptation.h"
#include "firmware/control/force/feedforward.h"
#include "firmware/control/force/hysteresis_memory.h"
#include "firmware/control/parameters/parameter_sets.h"
#include "firmware/control/tick_history.h"

namespace slipstack {

/// What the main loop keeps up to date of the friction model, from what the ticks have left since the last
/// time: the level of the friction and the mass, the memory of the hysteresis, the time that drift goes by,
/// and the weight of effects over position.
class ModelUpkeep {
 public:
  /// In every pass of the main loop, at least every TickHistory::kLatest ticks.
  void step(ParameterSets& sets, const TickHistory& history, PositionReference& place, bool driving) {
    const ControlSet& set = sets.active();
    const std::uint32_t last = sets.tick();
    fade(set.axis, last, place, driving);
    time_s_ = up_time_.at(last, set.axis.tick_s);
    sets.active().model.refresh(time_s_ + set.drift_begin_s);
    take_parameters(set, last);
    if (set.valid) adaptation_.limit(set.adaptation);
    history.follow(
        seen_, last, [&sets] { return sets.tick(); },
        [&](const TickHistory::Entry& entry, std::uint32_t missed) {
          if (missed > 0) memory_.miss(missed);
          memory_.step(entry.residual.place);
          if (!set.valid) return;
          adaptation_.step(set.adaptation,
                           {entry.point.counts, entry.point.velocity, entry.residual.dry_N,
                            entry.point.acceleration * set.mps2_per_count, entry.residual.residual_N});
        });
    if (set.valid) sets.active().add_mass(adaptation_.added_kg());
  }

  /// From the next step() on only this part of the level of the friction is in force, 0 to 1.
  void lower(float part) { adaptation_.lower(part); }

  /// What the adaptation adds to the mass of the model, kg.
  float added_kg() const { return adaptation_.added_kg(); }
  /// Of the friction; in the tick and outside it.
  float level() const { return adaptation_.level(); }
  const HysteresisMemory& memory() const { return memory_; }
  /// Since the start, as of the last step().
  float time_s() const { return time_s_; }

 private:
  static constexpr int kNoShift = 99;  // displacement has no unit yet

  // Effects over position come and go over the same time as parameters do.
  void fade(const AxisParameters& axis, std::uint32_t last, PositionReference& place, bool driving) {
    const auto passed = static_cast<float>(last - faded_);
    faded_ = last;
    place.fade(driving ? passed * axis.tick_s / axis.swap_time_s : 1.0F);
  }

  void take_parameters(const ControlSet& set, std::uint32_t last) {
    if (!set.valid) {
      seen_ = last;
      shift_ = kNoShift;
    }
    if (!set.valid || set.number == number_) return;
    if (set.hash != hash_ || number_ == 0) adaptation_.begin(set.adaptation);
    hash_ = set.hash;
    memory_.take(set.virgin_curve, set.displacement_shift == shift_);
    number_ = set.number;
    shift_ = set.displacement_shift;
  }

  Adaptation adaptation_;
  std::uint32_t hash_ = 0;  // of the model that it has learned of
  HysteresisMemory memory_;
  UpTime up_time_;
  float time_s_ = 0.0F;
  std::uint32_t faded_ = 0;   // the tick of the last fade()
  std::uint32_t seen_ = 0;    // the last tick that was followed
  std::uint32_t number_ = 0;  // of the parameters that the memory goes by
  int shift_ = kNoShift;
};

}  // namespace slipstack
