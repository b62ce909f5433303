// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "workbench/loop/live_axis.h"

namespace slipstack::workbench {

/// Which axis of the simulator is meant, and on which board its drive runs: the options of `commission`.
struct DrawnAxis {
  std::string board = "host";
  std::string image;
  std::string setup = "pick_and_place";
  std::int64_t seed = 1;
  std::string effects = "none";  ///< names, `none`, or `random`: one, drawn by the seed
  double strength = 0.0;
  bool motor_reversed = false;
};

/// The axis behind the firmware's controller, in lock-step (lockstep_axis.h). Throws UsageError.
std::unique_ptr<LiveAxis> live_axis(const DrawnAxis& wanted);

/// What tells it from other axes, whatever board drives it; says nothing of what was drawn.
std::string title_of(const DrawnAxis& wanted);

/// What was hidden in it: names with commas, or `none`.
std::string hidden_in(const DrawnAxis& wanted);

}  // namespace slipstack::workbench
