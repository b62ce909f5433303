// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/effects/effect.h"

namespace slipstack {

/// A lag adds no force of its own: the workbench puts its inverse on the measured force while fitting, the
/// controller advances its reference by delay and filter together. It therefore has shapes and no gain.
template <class Real>
class TimeDelay {
 public:
  static constexpr EffectText text{
      .id = "time_delay",
      .title = "Force and motion apart in time",
      .formula = "F(t) + T dF/dt = F_model(t - tau)",
      .source = "[1] set-up 2: phase beyond -180 degrees from sampling delay and filters",
      .residual =
          "appears where the force changes fast: at acceleration steps; its phase grows with frequency",
      .evidence =
          "force and motion are {delay} apart in time (positive: the force comes later), beside a low "
          "pass of {filter} (0: none)",
      .cause = "filters and sampling of drive and sensor, a slow current loop",
      .confirm = "step the current set-point with the axis clamped and time the measured force"};
  static constexpr std::array<GainGroup, 0> gains{{}};
  static constexpr std::array<ShapeSpec, 2> shapes{{
      {"delay", "s", -0.02f, 0.02f, ShapeKind::delay},
      {"filter", "s", 0.0f, 0.02f, ShapeKind::filter},
  }};
  /// Below a quarter of a sample it may come from how the recorder assigns time stamps, or from the damping
  /// of bristles, whose friction leads the displacement.
  static constexpr EffectTraits traits{
      .role = Role::measurement_delay,
      .plannable = false,
      .plausible = {.least_share_of_force = kRecorderErrs, .least_samples = 0.25}};
  static constexpr int gain_count = total_count(gains);
  static constexpr int shape_count = 2;

  void prepare(std::span<const Real, shape_count>, const Scales<Real>&) {}
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>&, std::span<Real, gain_count>) {}
};

}  // namespace slipstack
