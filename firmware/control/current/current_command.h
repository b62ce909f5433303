// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/control/current/current_limit.h"
#include "firmware/control/parameters/control_set.h"

namespace slipstack {

/// From the wanted force to the current: without a step where parameters or the mode change, and within the
/// limits of the current.
class CurrentCommand {
 public:
  /// In a tick in which the wanted force may step: it continues from the force before, and the difference
  /// fades. `from_rest`: there was no force before.
  void begin_fade(float wanted_N, bool from_rest) { blend_N_ = from_rest ? 0.0F : last_wanted_N_ - wanted_N; }

  /// One tick: the force to be made, what is still fading included.
  float faded(const ControlSet& set, float wanted_N) {
    const float force_N = wanted_N + blend_N_;
    blend_N_ *= set.blend_keep;
    last_wanted_N_ = force_N;
    return force_N;
  }
  /// The current within `largest_A` and its rate; adds to `limits` what applied.
  float limited(const ControlSet& set, float largest_A, float wanted_A, std::uint16_t& limits) {
    return limit_.step(largest_A, set.largest_step_A, wanted_A, limits);
  }

  /// No force fades any more.
  void end_fade() { blend_N_ = 0.0F; }
  /// Power stage off.
  void reset() {
    limit_.reset();
    end_fade();
  }
  float last_A() const { return limit_.last_A(); }

 private:
  CurrentLimit limit_;
  float blend_N_ = 0.0F;
  float last_wanted_N_ = 0.0F;
};

}  // namespace slipstack
