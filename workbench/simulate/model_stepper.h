// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// The force of a model instant by instant, by the same basis functions and the same composition
/// (model/composition.h) as in the fit. The inertia is kept separate, so that an integrator can solve for the
/// acceleration.
class ModelStepper {
 public:
  /// Copies what it needs of the terms. `tick_s`: time between steps.
  ModelStepper(const Terms& terms, double tick_s);

  /// The force at one instant: measured force = (mass x acceleration + friction_N) x factor.
  struct Forces {
    double friction_N = 0.0;  ///< all but the inertia, before the modulation of the whole force
    double factor = 1.0;      ///< product of the factors of effects that scale the whole force
  };

  /// Resets the state: hysteresis relaxed at the sample.
  void reset(const Sample<double>& sample);
  /// Advances the state of every effect by one step.
  Forces step(const Sample<double>& sample);

  /// Mass of the terms (inertia and payload); zero without.
  double mass_kg() const { return mass_kg_; }
  /// Largest tangent stiffness of the hysteresis.
  double stiffness_N_per_m() const { return stiffness_N_per_m_; }
  /// Delay and low pass of the measured force.
  const MeasurementDynamics& lag() const { return lag_; }

 private:
  struct Part {
    std::unique_ptr<EffectBasis> basis;
    std::vector<double> gains;
    std::vector<Acts> acts;
    std::vector<double> values;
    bool dry = false;
  };
  void run(Part& part, const Sample<double>& sample);

  std::vector<Part> parts_;  ///< dry friction first, because others modulate it
  double mass_kg_ = 0.0;
  double stiffness_N_per_m_ = 0.0;
  MeasurementDynamics lag_;
};

}  // namespace slipstack::workbench
