// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "workbench/estimate/measurement/measurement.h"
#include "workbench/model/effect_adapters/firmware_effects.h"
#include "workbench/model/term.h"

namespace slipstack::workbench {

/// Differences below this fraction of the peak force count as none.
inline constexpr double kSameForce = 1e-9;

/// The force of a fitted user-defined effect at any instant.
class UserForce {
 public:
  /// Keeps a reference to the term.
  explicit UserForce(const Term& term);

  std::vector<double> at(const std::vector<Sample<double>>& samples);

 private:
  const Term& term_;
  std::unique_ptr<EffectBasis> basis_;
};

/// What a force depends on, within the range of motion of a log.
struct Dependence {
  bool time = false;
  bool acceleration = false;
  bool position = false;
  bool speed = false;
  bool direction = false;  ///< of velocity
  bool odd = true;         ///< it changes sign with velocity
  double peak_N = 0.0;
};

/// The dependence of `force`, found by evaluation at instants of the log. `top_mps`: fastest speed of the
/// log.
Dependence dependence_of(const Measurement& measurement, UserForce& force, double top_mps);

/// Why a force of this dependence has no table; empty where it has one.
std::string form_fault(const Dependence& on);

}  // namespace slipstack::workbench
