// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "workbench/plan/information.h"

namespace slipstack::workbench {

/// The expected evidence for one effect against another, or against the baseline where `other` is empty.
struct ExpectedEvidence {
  std::string effect;
  std::string other;
  double angle_deg = 0.0;
  double chi_squared = 0.0;
  double evidence = 0.0;  ///< expected difference of BIC: n ln(1 + chi^2/n) - (more parameters) ln n
};

/// The evidence about the effects that is expected of a measurement with this baseline; of an excerpt, that
/// of the whole logs, assuming that they are alike.
std::vector<ExpectedEvidence> expected_evidence(const Measurement& measurement, const FittedModel& base,
                                                const Terms& effects);

/// Evidence above this is decisive: odds of 150 to 1 (Kass and Raftery 1995, difference of BIC above 10).
inline constexpr double kDecisive = 10.0;

/// The least evidence among the questions that either experiment answers, of each. An effect that contains
/// another can always imitate it; such questions are answered by none and do not count.
struct LeastEvidence {
  double log = 0.0;
  double plan = 0.0;
};
std::optional<LeastEvidence> least_evidence(const std::vector<ExpectedEvidence>& log,
                                            const std::vector<ExpectedEvidence>& plan);

/// The effects, each with shapes at which it may be mistaken for another.
std::vector<Information::Expected> expected_effects(const Measurement& measurement, const Terms& effects);

}  // namespace slipstack::workbench
