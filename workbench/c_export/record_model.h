// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "workbench/c_export/recording.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// What one tick of a friction model computes, as the firmware's FrictionModel::advance() did it.
struct RecordedModel {
  struct Effect {
    EffectText text;
    std::optional<ValueId> force_N;  ///< what it adds; nothing where it adds no force of its own
  };
  /// A number that an effect remembers from one tick to the next.
  struct Memory {
    ValueId now;    ///< state->memory[i]
    ValueId first;  ///< at the first instant
    ValueId next;
  };
  std::unique_ptr<ComputationRecord> recording;
  std::vector<Effect> effects;  ///< in the order in which they are computed
  std::vector<Memory> memory;
  ValueId force_N = 0;
  bool depends_on_tick = false;  ///< on the time between two ticks
};

/// How the recorded values name what is given.
inline constexpr const char* kTickName = "@TICK_S";

/// The displacement steps and the period of the tick that a model is prepared for.
struct ExportScales {
  double metres_per_step = 1.0;
  std::optional<double> tick_s;  ///< without: the name kTickName in its place
};

/// Records one tick of the model: in float what the controller computes, in double what the workbench does.
/// The terms are those of the controller. Throws NotRecordable: `id: reason`, for an effect that cannot be
/// recorded.
RecordedModel record_float(const Terms& target_terms, const ExportScales& scales);
RecordedModel record_double(const Terms& target_terms, const ExportScales& scales);

}  // namespace slipstack::workbench
