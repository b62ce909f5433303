// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim_host/plant/axis.h"
#include "workbench/loop/comparison/compared_drive.h"
#include "workbench/papers/analysis/friction_models.h"

namespace slipstack::workbench {

/// A way to compensate friction, with its parameters. What is no part of it is off.
struct Contender {
  std::string id;
  std::string title;
  std::string strength;  ///< what it has where it is best, a clause
  bool ours = false;
  AxisParameters axis;
  ModelParameters model;
  bool own_model = false;               ///< the friction of `model`, in the firmware's form
  double mass_share = 1.0;              ///< of the mass of `model` that is fed forward
  std::optional<FrictionFit> friction;  ///< a model of the literature, on the reference
  double level = 1.0;                   ///< by which its forces are multiplied
  double observer_share = 0.0;          ///< of the observed disturbance that is compensated
  // Iterative learning control: the feedback's force of one repetition, low-passed without delay, is added
  // to the feed-forward of the next one (Bristow, Tharayil, Alleyne, IEEE Control Systems 26(3) 2006).
  int repetitions = 1;
  double learning_gain = 0.0;
  double learning_cutoff_Hz = 0.0;

  bool learns_trajectory() const { return repetitions > 1; }
};

/// Its last repetition of this motion on this axis. About 1 µs per tick and repetition.
DriveRun run(const Contender& contender, const sim::Axis& axis, const Trajectory& trajectory,
             std::uint64_t noise_seed);

/// The contender with one of its parameters multiplied by `factor`, once for each: mass, level of the
/// friction, lengths and velocities of its model, share of the observer, gain and cut-off of the learning.
std::vector<Contender> each_parameter_times(const Contender& contender, double factor);

}  // namespace slipstack::workbench
