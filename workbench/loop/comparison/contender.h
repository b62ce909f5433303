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

/// What a contender is, whatever it is tuned to.
struct ContenderName {
  enum class Kind {
    kPeer,
    kLearner,  ///< of the trajectory
    kOurs,
    kBound  ///< no compensator, but what none can go below
  };
  std::string id;
  std::string title;
  std::string strength;  ///< what it has where it is best, a clause
  Kind kind = Kind::kPeer;
};

/// A way to compensate friction, with its parameters. What is no part of it is off.
struct Contender {
  ContenderName name;
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
  // Of a bound, which feeds forward the friction of the simulated axis itself.
  double noise_share = 1.0;    ///< of the axis's force noise
  double encoder_share = 1.0;  ///< of the step of its encoder

  bool bound() const { return name.kind == ContenderName::Kind::kBound; }
};

/// What the contender adds on this motion before anything has been learned. The axis matters to a bound
/// alone: of anything else it serves for every axis.
Compensation compensation_on(const Contender& contender, const sim::Axis& axis, const Trajectory& trajectory);

/// Its last repetition of this motion on this axis. About 0.4 µs per tick and repetition.
DriveRun run(const Contender& contender, const sim::Axis& axis, const Trajectory& trajectory,
             std::uint64_t noise_seed);
/// The same with a compensation that has been made before.
DriveRun run(const Contender& contender, const sim::Axis& axis, const Trajectory& trajectory,
             Compensation compensation, std::uint64_t noise_seed);

/// The contender with one of its parameters multiplied by `factor`, once for each: mass, level of the
/// friction, lengths and velocities of its model, share of the observer, gain and cut-off of the learning.
std::vector<Contender> each_parameter_times(const Contender& contender, double factor);

}  // namespace slipstack::workbench
