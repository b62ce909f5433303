// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "workbench/estimate/terms/terms.h"

namespace slipstack::workbench {

/// A model's force instant by instant, by the same basis functions that the fit uses: the sum of
/// firmware/effects/effect.h with its inertia set apart, so that an integrator can solve for the
/// acceleration.
class ModelStepper {
 public:
  /// Keeps the terms' values, not the terms. `tick_s`: between steps.
  ModelStepper(const Terms& terms, double tick_s);

  /// What the model says at one instant: measured force = (mass x acceleration + friction_N) x factor.
  struct Forces {
    double friction_N = 0.0;  ///< all but inertia, before the whole-force modulation
    double factor = 1.0;      ///< of effects that scale the whole force
  };

  /// A new start: hysteresis relaxed at the sample.
  void reset(const Sample<double>& sample);
  /// Advances every effect's state by one step.
  Forces step(const Sample<double>& sample);

  /// Mass of the terms (inertia and payload); zero without.
  double mass_kg() const { return mass_kg_; }
  /// Largest tangent stiffness of the hysteresis.
  double stiffness_N_per_m() const { return stiffness_N_per_m_; }
  /// By how much the measured force is late.
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

  std::vector<Part> parts_;  ///< dry friction first, since others modulate it
  double mass_kg_ = 0.0;
  double stiffness_N_per_m_ = 0.0;
  MeasurementDynamics lag_;
};

}  // namespace slipstack::workbench
