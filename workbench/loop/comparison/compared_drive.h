// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/control/force/force_control.h"
#include "sim_host/plant/axis.h"
#include "workbench/loop/comparison/trajectory.h"

namespace slipstack::workbench {

/// The tick of every comparison.
inline constexpr double kComparedTick_s = 1e-4;

/// What is added to the feedback.
struct Compensation {
  /// The model of the drive's parameters with its friction, as the firmware runs it, and its adaptation where
  /// the parameters ask for it. Else `friction_N` and the mass of the model.
  bool own_model = false;
  double mass_share = 1.0;              ///< of the mass of the model that is fed forward
  std::vector<double> friction_N = {};  ///< at each tick of the trajectory; empty: none
  std::vector<double> learned_N = {};   ///< the same, from repetitions
};

/// What a run leaves, at each tick.
struct DriveRun {
  std::vector<double> error_m;     ///< reference less true position
  std::vector<double> position_m;  ///< true
  std::vector<double> counts_m;    ///< as the encoder reads it
  std::vector<double> force_N;     ///< current times motor constant
  std::vector<double> feedback_N;
  double level = 1.0;
  bool lost = false;  ///< the axis left its reference by more than the following error; the run ends there
};

/// The firmware's estimate, feedback, limits and model around the simulated axis, with any feed-forward in
/// the place of the model's: the same loop for everything that is compared. It is the tick of the controller
/// in position mode without state machine and supervision; a test shows that both give the same current bit
/// for bit. The axis starts at rest and relaxed. About 1 µs per tick.
class ComparedDrive {
 public:
  /// Throws std::invalid_argument where the firmware refuses the parameters.
  ComparedDrive(sim::Axis axis, const AxisParameters& parameters, const ModelParameters& model,
                std::uint64_t noise_seed);

  DriveRun run(const Trajectory& trajectory, const Compensation& compensation) const;
  /// The same for points of the firmware's reference, the first one where the axis stands.
  DriveRun run(const std::vector<ReferencePoint>& reference, double start_m,
               const Compensation& compensation) const;

 private:
  sim::Axis axis_;
  AxisParameters parameters_;
  ModelParameters model_;
  std::uint64_t noise_seed_;
};

}  // namespace slipstack::workbench
