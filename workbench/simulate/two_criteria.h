// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "workbench/estimate/nonlinear/fit.h"

namespace slipstack::workbench {

/// Duration of the runs, where none is given. On EMPS [5], whose mechanical time constant (mass over viscous
/// friction) is 0.47 s, the position error of the last third by a fit to the first two falls with each of
/// nine horizons from 0.5 to 2.5 s, from 4.9 ... 5.9 mm to 2.8 ... 4.2 mm; with 1.25 s that of the whole log
/// falls most too (2026-11-22).
inline constexpr double kRunHorizon_s = 1.25;

/// Errors of force and of position from the force alone, of a model that was fitted by one criterion.
struct CriterionErrors {
  double force_N = 0.0;              ///< in sample
  double held_out_force_N = 0.0;     ///< each fifth of the runs by a fit to the others
  double forward_force_N = 0.0;      ///< the last third of each log by a fit to the first two
  double position_m = 0.0;           ///< in sample, each log in one run
  double held_out_position_m = 0.0;  ///< each fifth of the runs by a fit to the others
  double forward_position_m = 0.0;   ///< the last third of each log in one run, by a fit to the first two
};

/// A model fitted by inverse dynamics and refined by simulation, and how both do on data they have not seen.
struct SimulationFit {
  FittedModel model;  ///< refined, with standard errors; its errors are those of the force
  CriterionErrors inverse_dynamics;
  CriterionErrors simulation;
  std::size_t parameters = 0;  ///< refined ones
  std::size_t runs = 0;
  double run_s = 0.0;      ///< mean duration of a run
  bool converged = false;  ///< else the steps ended before the minimum was reached
};

/// Refines the gains of `start` by OutputErrorFit and judges both models. Errors of position are those of
/// free runs from the measured state. In the fits to a part of the data the shapes stay those of all. Throws
/// InputError, which names `logs`: no force that drives the axis, no mass, an excerpt of a long log, too
/// little without gaps, a model that runs away.
SimulationFit fit_by_simulation(const std::string& logs, const Measurement& measurement,
                                const FittedModel& start, double horizon_s,
                                const std::function<void(double fraction)>& progress);

/// What the controller runs of a model refined by simulation: `reduced`, made of the model before, with the
/// refined gains; its hysteresis with the refined level.
FittedModel with_refined_gains(const Measurement& measurement, const FittedModel& before,
                               const FittedModel& refined, FittedModel reduced);

}  // namespace slipstack::workbench
