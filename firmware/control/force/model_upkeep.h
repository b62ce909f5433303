// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/force/feedforward.h"
#include "firmware/control/force/hysteresis_memory.h"
#include "firmware/control/force/level_adaptation.h"
#include "firmware/control/parameters/parameter_sets.h"
#include "firmware/control/tick_history.h"

namespace slipstack {

/// What the main loop keeps up to date of the friction model, from what the ticks have left since the last
/// time: the level of the friction, the memory of the hysteresis, the time that drift goes by, and the weight
/// of effects over position.
class ModelUpkeep {
 public:
  /// In every pass of the main loop, at least every TickHistory::kLatest ticks.
  void step(ParameterSets& sets, const TickHistory& history, PositionReference& place, bool driving) {
    const ControlSet& set = sets.active();
    const std::uint32_t last = sets.tick();
    fade(set.axis, last, place, driving);
    if (set.valid) adaptation_.limit(set.adaptation);
    time_s_ = up_time_.at(last, set.axis.tick_s);
    sets.active().model.refresh(time_s_ + set.drift_begin_s);
    take_parameters(set, last);
    history.follow(
        seen_, last, [&sets] { return sets.tick(); },
        [&](const TickHistory::Entry& entry, std::uint32_t missed) {
          if (missed > 0) memory_.miss(missed);
          memory_.step(entry.residual.place);
          if (set.valid) adaptation_.step(set.adaptation, entry.residual.dry_N, entry.residual.residual_N);
        });
  }

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
    memory_.take(set.virgin_curve, set.displacement_shift == shift_);
    number_ = set.number;
    shift_ = set.displacement_shift;
  }

  LevelAdaptation adaptation_;
  HysteresisMemory memory_;
  UpTime up_time_;
  float time_s_ = 0.0F;
  std::uint32_t faded_ = 0;   // the tick of the last fade()
  std::uint32_t seen_ = 0;    // the last tick that was followed
  std::uint32_t number_ = 0;  // of the parameters that the memory goes by
  int shift_ = kNoShift;
};

}  // namespace slipstack
