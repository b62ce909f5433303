// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/loop/comparison/contender.h"

namespace slipstack::workbench {

/// What the contenders for an axis are made from: the feedback that `slipstack tune` proposes for its mass, a
/// log of the training motion by the drive with mass feed-forward, the mass and slipstack's model by that
/// log. Each function makes one kind of contender and tunes it, by the same optimiser where it is searched.
class Workshop {
 public:
  /// Records the training motion and fits. Throws std::runtime_error where the axis does not follow it. Some
  /// seconds of a processor.
  Workshop(const sim::Axis& axis, std::uint64_t seed);

  /// The mass alone.
  Contender plain(const ContenderName& name) const;
  /// The mass, which is not fed forward.
  Contender without_mass(const ContenderName& name) const;
  /// A friction model of the literature: fitted to the log, then its level searched in the loop.
  Contender with_friction(FrictionKind kind, const ContenderName& name) const;
  /// The same with the disturbance observer, its share searched in the loop.
  Contender with_observer(Contender contender) const;
  /// Iterative learning, gain and cut-off searched in the loop.
  Contender learning(const ContenderName& name) const;
  /// slipstack's model of the log with these effects more.
  Contender maxwell_slip(const ContenderName& name, const std::vector<std::string>& more) const;
  /// slipstack's model of the log with what `diagnose` finds missing in it.
  Contender diagnosed(const ContenderName& name) const;
  /// What is left with the friction known, with such shares of force noise and encoder step; the step stays
  /// at least 1 nm.
  Contender bound(const ContenderName& name, double noise_share, double encoder_share) const;

 private:
  void search_in_loop(Contender& contender, const std::vector<double Contender::*>& parameters,
                      const std::vector<ShapeRange>& ranges) const;

  const sim::Axis& axis_;
  std::uint64_t seed_;
  AxisParameters parameters_;
  Measurement measurement_;
  double mass_kg_;
  std::pair<double, double>
      lengths_m_;  // of pre-sliding, as slipstack's fit finds them: the same for all models
  ModelParameters own_model_;
  Trajectory loop_training_;
};

}  // namespace slipstack::workbench
