// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/plan/information.h"

namespace slipstack::workbench {

/// What one effect's evidence is against another's, or alone where `other` is empty.
struct ExpectedEvidence {
  std::string effect;
  std::string other;
  double angle_deg = 0.0;
  double chi_squared = 0.0;
  double evidence = 0.0;  ///< expected difference of BIC: n ln(1 + chi^2/n) - (more parameters) ln n
};

/// The evidence that a measurement with this baseline would hold about the effects; of an excerpt, what the
/// whole would hold if it were like it.
std::vector<ExpectedEvidence> expected_evidence(const Measurement& measurement, const FittedModel& base,
                                                const Terms& effects);

/// The effects, each with shapes at which it may pass for another.
std::vector<Information::Expected> expected_effects(const Measurement& measurement, const Terms& effects);

}  // namespace slipstack::workbench
